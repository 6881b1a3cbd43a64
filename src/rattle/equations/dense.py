"""Constraint rows as a dense matrix, for the few places that need one."""

from __future__ import annotations

import numpy as np

from rattle.equations.system import LARGE as LARGE
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace


def dense_rows(system: System, workspace: Workspace) -> np.ndarray:
    """The Jacobian Phi_q of the rows in the workspace as a dense array (nr, 3 nb), SI units."""
    nr = system.row_count
    full = np.zeros((nr, system.body_count + 1, 3))
    line, bodies, rows = np.arange(nr), system.arrays["row_body"], workspace.rows
    full[line, bodies[:, at.ROW_A]] += rows[:, at.AX : at.AP + 1]
    full[line, bodies[:, at.ROW_B]] += rows[:, at.BX : at.BP + 1]
    return full.reshape(nr, 3 * full.shape[1])[:, 3:]
