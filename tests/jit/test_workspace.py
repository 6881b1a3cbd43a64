"""The arrays of a run: declared once, found by name; what is not declared is refused."""

import numpy as np
import pytest

import rattle as rt
from rattle.jit import functions
from rattle.jit.functions import compiled
from rattle.jit.workspace import ARRAYS, Workspace


@compiled
def turned(m, k):
    return m.body[k, 2] + m.joint[0, 1]


@compiled
def turned_apart(k, m, other):
    return m.body[k, 2] - other.body[k, 2]


@compiled
def mistaken(m):
    return m.bodies[0, 0]


@pytest.mark.nojit
def test_an_array_that_is_not_declared_is_refused():
    with pytest.raises(TypeError, match="no array bodies"):
        Workspace({"bodies": np.zeros((1, 8))})
    with pytest.raises(TypeError, match="'body' is not a contiguous f2"):
        Workspace({"body": np.zeros(8)})
    with pytest.raises(TypeError, match="'held' has 12 of its"):
        Workspace({"held": np.zeros(12)})


def test_machine_code_reads_the_arrays_that_python_sees():
    functions.start()
    system = rt.example("fourbar").system
    workspace = system.workspace()
    workspace.body[2, 2] = 0.25
    assert turned(workspace, 2) == 0.25 + system.arrays["joint"][0, 1]
    assert workspace.body.shape == (system.body_count + 1, 8)
    assert {"body", "rows", "joint"} <= set(ARRAYS)


@pytest.mark.parametrize("make", ["workspace", "plain_workspace"])
def test_a_function_takes_several_workspaces_at_any_place(make):
    functions.start()
    system = rt.example("fourbar").system
    one, other = getattr(system, make)(), getattr(system, make)()
    one.body[2, 2], other.body[2, 2] = 0.75, 0.25
    assert turned_apart(2, one, other) == 0.5
    assert turned_apart(2, other, one) == -0.5
    assert turned_apart(2, one, one) == 0.0


@compiled
def last_of(m):
    return m.start_size[m.start_size.shape[0] - 1]


@pytest.mark.parametrize("make", ["workspace", "plain_workspace"])
def test_arrays_that_are_put_take_the_place_of_others(make):
    functions.start()
    workspace = getattr(rt.example("fourbar").system, make)()
    for numbers in ([1.0], [2.0, 3.0]):
        workspace.put({"start_size": np.array(numbers)})
        assert last_of(workspace) == numbers[-1] == workspace.start_size[-1]
    with pytest.raises(TypeError, match="no array bodies"):
        workspace.put({"bodies": np.zeros(1)})


def test_workspaces_that_one_function_gets_run_alike():
    """Also where machine code has been switched on between them."""
    functions.start()
    system = rt.example("fourbar").system
    plain = system.plain_workspace()
    assert system.assembly_workspace(plain).handle is functions.IN_PYTHON
    usual = system.workspace()
    assert (system.assembly_workspace(usual).handle is functions.IN_PYTHON) == (usual.handle is functions.IN_PYTHON)


def test_workspaces_of_one_system_share_no_number():
    system = rt.example("slider_crank_play").system
    one, other = system.workspace(), system.workspace()
    begin = {name: getattr(other, name).copy() for name in ARRAYS if not name.endswith("_table")}
    for name in begin:
        getattr(one, name)[...] = 7
    for name, array in begin.items():
        assert (getattr(other, name) == array).all()
        assert (getattr(system.workspace(), name) == array).all()


@pytest.mark.parametrize("clearance", [0.0004, 0.0006])
def test_mechanisms_of_one_structure_keep_their_own_numbers(clearance):
    system = rt.example("slider_crank_play").set(c=clearance).system
    workspace = system.plain_workspace()
    assert clearance in workspace.values
    assert all((getattr(workspace, name) == array).all() for name, array in system.arrays.items())


def test_a_wrong_name_does_not_compile():
    if not functions.start():
        pytest.skip("runs without machine code")
    with pytest.raises(Exception, match="bodies"):
        mistaken(rt.example("fourbar").system.workspace())
