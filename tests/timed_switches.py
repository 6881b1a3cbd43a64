"""Expressions of time by themselves, with the instants at which they switch."""

from types import SimpleNamespace

import numpy as np

from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.language.expression import compile_program, concatenate, parse
from rattle.language.instants import find_instants, search_arrays
from rattle.language.switching import Signals, find_switches
from rattle.language.tables import NO_TABLES


def switches(text, end, tables=NO_TABLES, **signals):
    """Switches of an expression over t, b.x and tables: `timed`, and of those of time alone instants, sides, resolved.

    Beside them the workspace in which they were found, and where the program of the expression stands in `code`.
    """
    functions.start()
    numbers = {name: k for k, name in enumerate(signals)}
    names = list(tables.curves)
    parsed = (parse(one, tables=names) if names else parse(one) for one in (*signals.values(), text))
    programs = [compile_program(one, {}, {"b.x": 8}, numbers, tables) for one in parsed]
    code, const, first, depth = concatenate(programs, tables)
    rows = [(int(first[k]), int(first[k + 1]), k) for k in range(len(signals))]
    own = int(first[-2]), int(first[-1])
    found = find_switches(Signals(code, const, rows, list(signals)), [(*own, "it", True)])
    timed = [(one.first, one.last, one.row, 1, 1, 0, 0, 0, 0) for one in found if one.timed]
    needed = 64
    while needed:
        m = Workspace(
            {
                "code": code, "const": const, "signal": np.array(rows, np.int64).reshape(-1, 3),
                "timed": np.array(timed, np.int64).reshape(-1, 9), "joint_table": np.zeros(0, np.int64),
                **search_arrays(max(1, len(signals)), depth, 4 * needed),
            }
        )  # fmt: skip
        needed = find_instants(m, 0.0, end)
    ahead = iter(m.timed)
    return [_said(m, next(ahead)) if one.timed else SimpleNamespace(timed=False) for one in found], m, own


def _said(m, row):
    ours = m.switchings[row[at.FIRST_FOUND] : row[at.END_FOUND]]
    return SimpleNamespace(
        timed=True, resolved=bool(row[at.RESOLVED]), sides=ours[:, at.SIDE_AFTER],
        instants=ours[1:, at.SWITCHES_AT],
    )  # fmt: skip
