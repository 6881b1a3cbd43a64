"""Studies: analyses that run a mechanism many times."""
