"""Kinematic accuracy: the effect of clearances on an output."""
