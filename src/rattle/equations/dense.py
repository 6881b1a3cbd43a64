"""Constraint rows as a dense matrix, for the few places that need one."""

from __future__ import annotations

import numpy as np

from rattle.equations.system import System
from rattle.jit.workspace import Workspace

LARGE = 400  # number of rows above which dense linear algebra is avoided and starting the machine code pays off


def dense_rows(system: System, workspace: Workspace) -> np.ndarray:
    """The Jacobian Phi_q of the rows in the workspace as a dense array (nr, 3 nb), SI units."""
    nr = system.row_count
    full = np.zeros((nr, 3 * (system.body_count + 1)))
    line = np.arange(nr)[:, None]
    for side, columns in ((0, slice(3, 6)), (1, slice(6, 9))):
        np.add.at(full, (line, 3 * system.arrays["row_body"][:, side, None] + np.arange(3)), workspace.rows[:, columns])
    return full[:, 3:]
