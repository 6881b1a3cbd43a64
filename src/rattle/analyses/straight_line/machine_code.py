"""Functions of graphs as machine code: gathered first, compiled at once, called with arrays of samples in columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle.trace import llvm
from rattle.trace.graph import Graph
from rattle.trace.lane_program import Function


class MachineFunctions:
    """Functions (rows in (n_in, n), rows out (n_out, n)) of graphs of exact operations, for n a multiple of 8.

    Arrays are float64 and C-contiguous and do not overlap.  They may be called after `compile`, from several threads.
    """

    def __init__(self, width: int | None = None) -> None:
        self.width = llvm.width() if width is None else width
        self._texts: list[str] = []
        self._code: llvm.MachineCode | None = None
        self._calls: dict[int, Any] = {}

    def add(self, graph: Graph, outputs: Sequence[Any]) -> Function:
        """A function that will be compiled with the others."""
        number = len(self._texts)
        self._texts.append(llvm.functions_text(graph, {f"f{number}": outputs}, self.width))

        def call(rows_in: np.ndarray, rows_out: np.ndarray) -> None:
            self._calls[number](rows_in.ctypes.data, rows_out.ctypes.data, rows_in.shape[1])

        return call

    def compile(self) -> None:
        """Make the machine code of all functions."""
        names = [f"f{n}" for n in range(len(self._texts))]
        self._code = llvm.compile("\n".join(self._texts), names)
        self._calls = {n: self._code.function(name) for n, name in enumerate(names)}
