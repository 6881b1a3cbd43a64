"""The scoreboard: error against processor time of rattle, Exudyn and MuJoCo for models that all can solve."""
