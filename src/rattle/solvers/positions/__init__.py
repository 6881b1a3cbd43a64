"""Positions without time integration: equilibria, and positions along a given motion of the drivers."""
