"""Time integration methods, one in each file: step, dense output and what the method declares."""
