"""Putting a mechanism together, and what it then is."""
