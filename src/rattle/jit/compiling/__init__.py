"""What Numba does: laws that users write in Python, and all kernels on the plain way."""
