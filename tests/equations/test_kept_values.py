"""Given values at the start are kept as the two least changes say that `kept_values` describes."""

import numpy as np
import pytest

import random_mechanisms
import rattle as rt
from rattle.equations import kept_values
from rattle.equations.closure import open_by
from rattle.equations.dense import dense_rows
from rattle.equations.kept_values import CHANGE, ROUNDING, WANTED, least_change, take_roots, take_rows
from rattle.equations.system import System

LINKAGES = ("fourbar", "slider_crank", "jansen_leg", "squeezer", "scissor_lift", "double_pendulum")


def shortest(matrix: np.ndarray, side: np.ndarray, root: np.ndarray) -> np.ndarray:
    """By singular values, what the kernel finds by reflections."""
    if not side.any() or not matrix.size:
        return np.zeros(len(root))
    length = np.linalg.norm(matrix * root, axis=1)
    length = np.where(length > 0.0, length, 1.0)[:, None]
    return root * np.linalg.lstsq(matrix * root / length, side / length[:, 0], rcond=kept_values.RANK)[0]


def two_stages(system: System, jacobian: np.ndarray, wanted: np.ndarray, known: np.ndarray) -> np.ndarray:
    root = np.sqrt(system.arrays["weight"][1:].ravel())
    change, others = np.zeros(len(root)), jacobian[:, ~known]
    if known.any():
        scale = np.tile([1.0, 1.0, 1.0 / system.size], system.body_count)
        left = np.eye(len(wanted))
        if others.size:
            u, values, _ = np.linalg.svd(others * scale[~known])
            values = np.concatenate([values, np.zeros(max(0, len(wanted) - len(values)))])
            left = u[:, values[: len(wanted)] <= kept_values.RANK * values[0]]
        change[known] = shortest(left.T @ jacobian[:, known], left.T @ wanted, root[known])
    if others.shape[1]:
        change[~known] = shortest(others, wanted - jacobian[:, known] @ change[known], root[~known])
    return change


def systems() -> list[tuple[str, System, np.ndarray]]:
    named = [(name, rt.example(name)) for name in LINKAGES]
    named += [(f"friction {n}", rt.Mechanism.from_text(random_mechanisms.mechanism(n, "friction"))) for n in range(6)]
    return [(name, m.system, m.start.q) for name, m in named if not len(m.system.arrays["massless"])]


@pytest.mark.parametrize(("name", "system", "q"), systems())
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("fitting", [True, False])
def test_both_changes_are_the_least(name: str, system: System, q: np.ndarray, share: float, fitting: bool) -> None:
    random = np.random.default_rng(len(name))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rattle.jit.functions._jit", False)
        workspace = system.assembly_workspace()
    open_by.python(workspace, 0.0, q, np.zeros_like(q))
    assert take_rows.python(workspace)
    take_roots.python(workspace)
    jacobian = dense_rows(system, workspace)
    assert np.array_equal(workspace.kept_rows, jacobian)
    known = random.uniform(size=len(q)) < share
    wanted = jacobian @ random.standard_normal(len(q)) if fitting else random.standard_normal(len(jacobian))
    workspace.kept_sides[WANTED], workspace.kept_sides[ROUNDING] = wanted, 0.0
    least_change.python(workspace, np.where(known, 0.0, np.nan), system.size)
    expected = two_stages(system, jacobian, wanted, known)
    got = workspace.kept_places[CHANGE]
    if fitting or np.linalg.matrix_rank(jacobian) == len(jacobian):
        assert got == pytest.approx(expected, rel=1e-7, abs=1e-9 * np.abs(expected).max(initial=1e-9))
    else:  # of rows that contradict each other, what is left open is the least
        assert np.linalg.norm(jacobian @ got - wanted) <= np.linalg.norm(wanted) * (1.0 + 1e-9)


@pytest.mark.parametrize("name", ["crank_rocker_play", "squeezer", "fourbar", "torque_converter"])
def test_plain_python_and_machine_code_start_alike(name: str) -> None:
    m = rt.example(name)
    parameter = next(key for key, one in m.model.parameters.items() if one.unit == "m")
    moved = {parameter: m.parameters[parameter] * 1.001}
    here = m.neighbour(moved).start
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rattle.jit.functions._jit", False)
        plain = rt.example(name).neighbour(moved).start
    assert plain.q == pytest.approx(here.q, rel=0.0, abs=1e-13)
    assert plain.v == pytest.approx(here.v, rel=0.0, abs=1e-12 * max(1.0, np.abs(here.v).max()))
