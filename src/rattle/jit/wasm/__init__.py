"""The kernels as one WebAssembly module: translated, linked, compiled and given its sections."""
