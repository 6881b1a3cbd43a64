"""All arrays of one run behind one small handle.

A compiled function takes the handle and asks for the arrays it reads and writes by number:
`rows = mat(m, ROWS)`.  In machine code the handle is an integer array of addresses and shapes, so a call
passes one argument however many arrays there are (with named tuples of forty arrays the four-bar ran 2.5 times
as long and compiled 1.5 times as long); in plain Python it is the tuple of arrays itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rattle.jit import functions

# name, what it holds; f: float64, i: int64, number of dimensions; a kernel table is a vector of addresses
FIELDS = {
    # the mechanism: read-only in a run, shared by all runs
    "mass": "f2",  # (nb + 1, 3) m, m, J  [kg, kg, kg*m^2]; row 0 is the ground
    "weight": "f2",  # (nb + 1, 3) 1 / mass, zero for the ground
    "gravity": "f1",  # (2,) [m/s^2]
    "joint": "i2",  # (nj, 5) kernel, A, B, first parameter, first row; joints first, then drivers
    "load": "i2",  # (nl, 5) kernel, A, B, first parameter, 1 if its values change during the run
    "contact": "i2",  # (nc, 13) one per contact point, see jit.layout
    "lever": "f2",  # (nc, 3) longest arms on A and on B to what may touch [m]; 1 if the walls turn with A, else 0
    "code": "i2",  # (nc, 4) programs of all expressions, one after the other, with the sides of their switches
    "const": "f1",  # numbers in them
    "jet": "i2",  # (nd, 3) first, last code row and parameter of every driver's function
    "jet_signal": "i2",  # (ne, 3) first, last code row and number of every signal a driver uses
    "signal": "i2",  # (ns, 3) first, last code row and number of every signal
    "live": "i2",  # (nv, 3) first, last code row and parameter of every changing value of a load
    "switch": "i2",  # (nk, 4) switches that depend on the state: first, last row of operands, own row, their number
    "watch": "i1",  # (nw,) rows whose force must not become negative (two-sided contact)
    "place": "i1",  # see schur.Pattern, also the next four
    "first": "i1",
    "below": "i1",
    "target": "i1",
    "pairs": "i2",
    "row_body": "i2",  # (nr, 2) bodies A, B of every row
    "joint_table": "i1",  # kernels
    "load_table": "i1",
    "clearance_table": "i1",
    "stiffness_table": "i1",
    "normal_table": "i1",
    "friction_table": "i1",
    # this instant, in the order in which it is filled
    "values": "f1",  # (np,) parameters of joints and loads
    "signals": "f1",  # (ns,)
    "jets": "f2",  # (ns, 3)
    "stack": "f1",
    "jet_stack": "f2",
    "jet_out": "f1",  # (3,)
    "body": "f2",  # (nb + 1, 8) see jit.layout
    "rows": "f2",  # (nr, 9) see jit.layout
    "force": "f2",  # (nb + 1, 3) applied forces Q  [N, N, N*m]
    "energy": "f1",  # (4,) of one load, see jit.layout
    "power": "f1",  # (4,) potential [J], work rate, dissipation [W], smallest share of a pivot
    "schur": "f1",  # Schur complement and its factor
    "inverse": "f1",  # (nr,) 1 / pivot, in elimination order
    "redundant": "i1",  # (nr,) in elimination order
    "x": "f1",  # (nr,) right side and solution in elimination order
    "multiplier": "f1",  # (nr,) lambda
    "acceleration": "f2",  # (nb + 1, 3)
    "change": "f1",  # (3 nb,) a correction of positions or rates
    "touch": "f2",  # (nc, 18) geometry and forces of every contact, see jit.layout
    "grip": "f2",  # (nc, 13) its memory, see jit.layout
    "rate": "f1",  # (1,) rate of a bristle
    # set-valued contacts, see equations.unilateral; two lines (normal, tangential) for each contact that takes part
    "mode": "i1",  # (nc,) what each contact does: OFF, STICK, FORWARD, BACKWARD
    "chosen": "i1",  # (nc,) contacts that take part
    "trial": "i1",  # (nc,) their modes while the problem is being solved
    "slide": "i1",  # (nc,) sign of their slip where it is known beforehand, else 0
    "pivot": "i1",  # (2 nc,) scratch
    "arm": "f2",  # (2 nc, 6) w: rates of A, then of B, to normal or tangential velocity
    "direction": "f2",  # (2 nc, 3 nb) M^-1 (w - Phi_q^T z): what a unit force changes
    "reply": "f2",  # (2 nc, nr) z: multipliers that a unit force calls up
    "delassus": "f2",  # (2 nc, 2 nc) G
    "side": "f2",  # (4, 2 nc) b, f, a of a = G f + b, and another solution
    "system": "f2",  # (2 nc, 2 nc + 1) scratch
    "series": "f2",  # (nc, 2) times of the last impact of each contact and of the one before
    "pushed": "f2",  # (nb + 1, 3) M^-1 (W^T f - Phi_q^T z): what all forces f change together
    "called": "f1",  # (nr,) z: multipliers that they call up
    "path": "f2",  # (6, 2 nc) b, d, and f, a that d alone would have, see equations.lemke; modes, a or f of a solution
    "bounce": "f2",  # (7, 2 nc) see solvers.nonsmooth.impact_path and phases
    "looks": "f2",  # (looks, 4 nc + 2) places of a step that were looked at, see solvers.nonsmooth.event_search
    "glances": "f2",  # (9, 4 nc + 2) the same at the stages of a step, see solvers.glances
    "held": "f1",  # (8,) see equations.unilateral and complementarity
    "net_place": "i1",  # (nr + 2 nc,) rows of joints and contacts together, see contact_network, also the next twelve
    "net_first": "i1",
    "net_below": "i1",
    "net_target": "i1",
    "net_pairs": "i2",
    "net_row": "i1",  # (nr + 2 nc,) row at each place
    "net_on": "i1",  # (nr + 2 nc,) 1 if the row takes part
    "net_line": "f2",  # (nr + 2 nc, 6) R
    "net_column": "f2",  # (nr + 2 nc, 6) M^-1 C^T
    "net_size": "f1",  # (nr + 2 nc,) diagonal without friction
    "net_lower": "f1",
    "net_upper": "f1",
    "net_x": "f2",  # (2, nr + 2 nc) solution, correction, by place
    "hold_table": "i1",  # the kernel that adds the forces of lasting contacts, if there may be any
    "problem_table": "i1",  # kernels that solve contact problems, see equations.unilateral
    # the march in time
    "y": "f1",  # (6 nb + 2,) q, v, work done, energy dissipated at clock[T]
    "f": "f1",  # its derivative
    "y_new": "f1",
    "f_new": "f1",
    "stage": "f1",
    "k": "f2",  # (16, ny) derivatives at the stages
    "dense": "f2",  # (7, ny)
    "clock": "f1",  # see solvers.step_loop
    "tally": "i1",  # see solvers.step_loop
    "sign": "f1",  # (nw,) sign of every watched force
    "crossings": "f2",  # (n, 3) time, watched force, new sign
    "events": "f2",  # (n, 8) see jit.layout
    "measure": "f1",  # (nr,) what a residual is measured with: 1 / length of the mechanism [1/m], or 1 for angles
    "audit": "f1",  # see solvers.step_audit
    "quantity": "i2",  # (np, 2) what is watched for peaks, and its first column behind those of bodies, see jit.layout
    "peaks": "f2",  # (np, 16) their largest values, mean squares and samples of the present step
    "peak_row": "f1",  # the columns of joints of an output row, scratch
    "landing": "f1",  # (5,) see solvers.state_switches
}

(
    MASS, WEIGHT, GRAVITY, JOINT, LOAD, CONTACT, LEVER, CODE, CONST, JET, JET_SIGNAL, SIGNAL, LIVE, SWITCH, WATCH,
    PLACE, FIRST, BELOW, TARGET, PAIRS, ROW_BODY, JOINT_TABLE, LOAD_TABLE, CLEARANCE_TABLE, STIFFNESS_TABLE,
    NORMAL_TABLE,
    FRICTION_TABLE, VALUES, SIGNALS, JETS, STACK, JET_STACK, JET_OUT, BODY, ROWS, FORCE, ENERGY, POWER, SCHUR,
    INVERSE, REDUNDANT, SOLUTION, MULTIPLIER, ACCELERATION, CHANGE, TOUCH, GRIP, BRISTLE_RATE, MODE, CHOSEN, TRIAL,
    SLIDE, PIVOTS, ARM, DIRECTION, REPLY, DELASSUS, SIDE, SYSTEM, RECENT, PUSHED, CALLED, PATH, BOUNCE, LOOKS,
    GLANCES, HELD, NET_PLACE,
    NET_FIRST, NET_BELOW, NET_TARGET, NET_PAIRS, NET_ROW, NET_ON, NET_LINE, NET_COLUMN, NET_SIZE, NET_LOWER, NET_UPPER,
    NET_X, HOLD_TABLE, PROBLEM_TABLE, STATE, RATE, STATE_NEW, RATE_NEW, STAGE, SLOPES, DENSE, CLOCK, TALLY, SIGN,
    CROSSINGS, EVENTS, MEASURE, AUDIT, QUANTITY, PEAKS, PEAK_ROW, LANDING,
) = range(len(FIELDS))  # fmt: skip


class Memory:
    """The arrays of one run by name, and the handle that compiled functions take."""

    def __init__(self, arrays: Mapping[str, Any]) -> None:
        self._arrays = {name: arrays[name] if name in arrays else _empty(kind) for name, kind in FIELDS.items()}
        for name, kind in FIELDS.items():
            array = self._arrays[name]
            if isinstance(array, np.ndarray):  # a table of Python functions is a tuple
                dtype = np.float64 if kind[0] == "f" else np.int64
                if array.dtype != dtype or array.ndim != int(kind[1]) or not array.flags.c_contiguous:
                    raise TypeError(f"array '{name}' is not a contiguous {kind}: {array.dtype}, {array.shape}")
        self.handle: Any = functions.PlainHandle(self._arrays.values())
        if isinstance(self._arrays["joint_table"], np.ndarray) and functions.jit_runs():
            self.handle = np.array(
                [(a.ctypes.data, a.shape[0], a.shape[-1]) for a in self._arrays.values()], np.int64
            ).ravel()

    def __getitem__(self, name: str) -> np.ndarray:
        return self._arrays[name]


def _empty(kind: str) -> np.ndarray:
    return np.zeros((0,) * int(kind[1]), np.float64 if kind[0] == "f" else np.int64)


def vec(m: Any, k: int) -> Any:
    """Float vector number k of the memory m."""
    return m[k]


def mat(m: Any, k: int) -> Any:
    """Float matrix number k."""
    return m[k]


def ivec(m: Any, k: int) -> Any:
    """Integer vector number k."""
    return m[k]


def imat(m: Any, k: int) -> Any:
    """Integer matrix number k."""
    return m[k]


@functions.before_compiling
def teach_views(compiling: Any) -> None:
    """Let Numba make arrays of the addresses and shapes in a handle."""
    from rattle.jit import blocks

    blocks.views(vec, blocks.VECTOR)
    blocks.views(mat, blocks.MATRIX)
    blocks.views(ivec, blocks.WHOLES)
    blocks.views(imat, blocks.WHOLE_ROWS)
