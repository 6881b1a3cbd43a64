"""Kinematics and inverse dynamics of driven mechanisms, position by position."""
