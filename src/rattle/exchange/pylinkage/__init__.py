"""Mechanisms of pylinkage: joints with places, and links that join them, as JSON."""
