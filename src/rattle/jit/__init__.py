"""Compilation to machine code: the only room that imports Numba."""
