"""Ideal joints and drivers: one kind per file, each with a few constraint rows."""
