"""Leaves: joints, clearances, contact laws and loads, found through the registry and imported by nobody by name."""
