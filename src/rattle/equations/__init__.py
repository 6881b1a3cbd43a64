"""Everything at one instant."""
