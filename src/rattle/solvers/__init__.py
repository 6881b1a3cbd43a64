"""Time steppers: stateless, compiled, one call for many steps."""
