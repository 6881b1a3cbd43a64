"""Steps that ask for samples, set aside: inside of them a curve may have a larger value than at the ends of steps."""

from __future__ import annotations

from collections.abc import Sequence

from rattle.trace.graph import both, select
from rattle.trace.lane_control import Status
from rattle.trace.lane_methods import Method, Recorded, finite_flag, flag, inputs
from rattle.trace.peak import peak
from rattle.trace.reductions import Ledger


def results(ledger: Ledger, method: Method, ny: int, later: Sequence[int]) -> Recorded:
    """Curves and flag at the start of a step and at the end of its parts, blocks as in `checks`: a value for each of
    `Ledger.screened`, and the `Status` of `Aside`.

    later: stages for the dense output alone.
    """
    wide, size = ledger.curves + 1, ny + 2 + len(ledger.watched)
    graph, row = inputs((1 + ledger.samples) * wide + (3 + method.slopes) * size)
    samples = [row[k * wide : (k + 1) * wide] for k in range(1 + ledger.samples)]
    blocks = row[(1 + ledger.samples) * wide :]
    flags = [sample[-1] for sample in samples[1:]] + [blocks[(3 + s) * size + ny + 1] for s in later]
    sound, finite = (
        both(graph, [flag(graph, x) for x in flags]),
        finite_flag(graph, row[wide : len(samples) * wide]),
    )
    status = select(finite, select(sound, 0.0, float(Status.ASSUMPTION)), float(Status.NOT_FINITE))
    return graph, [*(peak([extreme.sign * x[extreme.curve] for x in samples]) for extreme in ledger.screened), status]
