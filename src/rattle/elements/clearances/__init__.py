"""Clearance models: what a joint with play becomes."""
