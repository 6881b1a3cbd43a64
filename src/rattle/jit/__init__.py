"""Machine code: the only room that imports Numba."""
