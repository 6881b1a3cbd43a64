"""Largest values and mean squares of forces, from forces that the stages of a step need anyway."""
