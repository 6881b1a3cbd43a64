"""Sensitivities: exact derivatives of curves by parameters, along a motion or at single positions."""
