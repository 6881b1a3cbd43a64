"""Arrays of a run with set-valued contacts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rattle.equations import complementarity, contact_network, lemke, unilateral
from rattle.equations.system import System
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.solvers.nonsmooth import event_search, impact_chain, impact_path, impact_phases, implicit_forces, uniqueness
from rattle.solvers.peaks import contact_samples


def contact_arrays(system: System, looks: np.ndarray | None = None) -> dict[str, Any]:
    """Arrays for set-valued contacts besides those of one instant.

    looks: shares of the step at which its stages show forces, if closed contacts are constraints whose forces are part
    of the equations of motion.
    """
    nc, nr, nb = len(system.arrays["contact"]), system.row_count, system.body_count
    contact, solvers = system.arrays["contact"], (contact_network.KERNEL, lemke.KERNEL, uniqueness.KERNELS[0])
    laws = (
        impact_phases.expand_kernel,
        impact_path.path_kernel,
        uniqueness.KERNELS[1],
        impact_chain.chain_kernel,
    )
    soft = {} if looks is not None else _soft_arrays(contact, nb, nr)
    held = np.zeros(at.width("held"))
    held[[at.DETERMINANT, at.SIZE, at.WEAKEST, at.LOCK_SHARE]] = 1.0, system.size, 1.0, 1.0
    return {
        **({} if soft or nc <= complementarity.FEW else contact_network.arrays(system.arrays["row_body"], contact)),
        **soft,
        **{name: np.zeros(nc, np.int64) for name in ("mode", "active", "candidate", "slide", "jammed")},
        "pivots": np.zeros(2 * nc, np.int64),
        "row_fixed": np.zeros(2 * nc, np.int64),
        "impact_reaction": np.zeros(nr),
        "expected_force": np.zeros(2 * nc),
        "contact_jacobian": np.zeros((2 * nc, 6)),
        "velocity_response": np.zeros((2 * nc, 3 * nb)),
        "multiplier_response": np.zeros((2 * nc, nr)),
        "delassus": np.zeros((2 * nc, 2 * nc)),
        "side": np.zeros((4, 2 * nc)),
        "system": np.zeros((2 * nc, 2 * nc + 1)),
        "recent": np.full((nc, at.width("recent")), -math.inf),
        "stuck": np.zeros(at.width("stuck")),
        "velocity_change": np.zeros((nb + 1, 3)),
        "multiplier_change": np.zeros(nr),
        "path": np.zeros((6, 2 * nc)),
        "bounce": np.zeros((7, 2 * nc)),
        "chain": np.zeros((impact_chain.ROWS, 2 * nc)),
        "looks": np.zeros((event_search.LOOKS_KEPT, contact_samples.KINDS * nc + 2)),
        "held": held,
        "problem_table": functions.entries((*complementarity.KERNELS, *solvers, *laws)),
        **(
            {
                "closed_contacts_table": functions.entries([unilateral.closed_contacts]),
                "glances": contact_samples.table(nc, looks),
            }
            if looks is not None
            else {}
        ),
    }


def _soft_arrays(contact: np.ndarray, nb: int, nr: int) -> dict[str, np.ndarray]:
    """Arrays of compliant contacts and films of time stepping; none if there are none."""
    soft = np.flatnonzero(contact[:, at.IMPACT] == 0)
    size = implicit_forces.PER * len(soft)
    if not size:
        return {}
    return {
        "soft": soft,
        "soft_place": np.zeros((len(soft), 2)),
        "soft_jacobian": np.zeros((size, 6)),
        "soft_response": np.zeros((size, 3 * nb)),
        "soft_reaction": np.zeros((size, nr)),
        "soft_delassus": np.zeros((size, size)),
        "soft_slope": np.zeros((size, implicit_forces.PER)),
        "soft_matrix": np.zeros((size, size)),
        "soft_order": np.zeros(size, np.int64),
        "soft_force": np.zeros((implicit_forces.WORK + 1, size)),
        "soft_free": np.zeros(3 * nb + 3 + nr),
    }
