"""Growth of a small difference by the exact variational equations of a recorded model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.analyses.straight_line.machine_code import MachineFunctions
from rattle.analyses.straight_line.variational_model import VariationalModel
from rattle.errors import TraceError
from rattle.questions.lyapunov.neighbouring_runs import Apart
from rattle.solvers.dop853_tableau import TABLEAU
from rattle.solvers.stepper import ATOL
from rattle.trace.lane_batch import Batch
from rattle.trace.lane_control import Status
from rattle.trace.lane_methods import Method, Tolerances
from rattle.trace.lane_program import EIGHT, Program
from rattle.trace.lane_start import Stock
from rattle.trace.reductions import Reduction

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

MOST_OPERATIONS = 20_000  # of right-hand side and projection with their derivatives; beyond, code is slow to make
LOOKS = 64  # steps between two looks whether a stretch is through
MOST_STEPS = 10**9


def growths(m: Mechanism, first: np.ndarray, apart: Apart, times: np.ndarray, rtol: float) -> np.ndarray:
    """(n,) natural logarithm of the growth of a difference in every stretch that ends at times (n,) [s].

    first: (n,) direction of the difference at the start, weighted; it is projected onto the constraints.
    apart: what differs, and how it counts.
    Raises TraceError, with the reason, where the model cannot be recorded or straight-line code cannot follow it.
    """
    if m.system.switches:
        names = ", ".join(sorted({switch.name for switch in m.system.switches}))
        raise TraceError(f"steps must end where expressions switch ({names})")
    variational = VariationalModel(m.recorded(), apart.places, apart.weight(len(times) // 2))
    if variational.operations > MOST_OPERATIONS:
        raise TraceError(
            f"its {variational.operations} operations are more than the {MOST_OPERATIONS} up to which straight-line"
            " code pays"
        )
    functions = MachineFunctions()
    program = Program(
        variational.lane_model(first, functions.add), functions.add, Method(TABLEAU), [Reduction("final", 0)],
        float(times[-1]), tolerances=Tolerances(rtol, ATOL * rtol), chain=functions.chain, tiled=True,
        most_steps=MOST_STEPS,
    )  # fmt: skip
    functions.compile()
    lane = np.zeros(1, dtype=np.int64)
    batch, stock = Batch(program, EIGHT, LOOKS), Stock(program, EIGHT)
    with np.errstate(all="ignore"):
        _require(int(stock.fill(np.zeros((0, 1)))[0]), 0.0)
        batch.take(lane, stock, lane, lane)
        sizes = np.zeros(1 + len(times))
        for k, t in enumerate(times):
            batch.go_on(lane, t)
            while not len(batch.step()):
                pass
            _require(int(batch.ended(lane)[0][0]), t)
            sizes[k + 1] = batch.states(lane)[variational.logarithm, 0]
    return np.diff(sizes)


def _require(status: int, t: float) -> None:
    if status != Status.DONE:
        raise TraceError(f"its motion {Status(status).words}, before t = {t:.6g} s")
