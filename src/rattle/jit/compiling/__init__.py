"""What makes machine code with Numba: the fast way, the plain way, and what both share."""
