"""Compilation to machine code: the only room that knows LLVM, and Numba for laws of users."""
