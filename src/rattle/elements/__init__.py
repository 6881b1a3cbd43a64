"""Joints, clearances, contact laws and loads, found through the registry; no module imports them by name."""
