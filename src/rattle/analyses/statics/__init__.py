"""Equilibrium, quasi-static motion, small vibrations."""
