"""Ideal joints and drivers: one kind per file, each a few constraint rows."""
