"""Largest values and mean squares of forces, told from what the stages of a step show anyway."""
