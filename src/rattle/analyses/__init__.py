"""Analyses of a mechanism: assembly, kinematics, dynamics, statics, accuracy, checks."""
