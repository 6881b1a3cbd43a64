"""Drawings as DXF, the format in which programs for drawing exchange them."""
