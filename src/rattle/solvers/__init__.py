"""Time integration: compiled, without state of its own, one call for many steps."""
