"""Our own way from kernels to machine code: their sources are translated for LLVM, one function after the other."""
