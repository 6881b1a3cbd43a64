"""[tables]: what is read, from the model and from files beside it, what is refused, and what is written again."""

from __future__ import annotations

import numpy as np
import pytest

import rattle as rt

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

BLOCK = """format = 1
{head}
[ground.points]
O = [0, 0]
[bodies.block]
points = {{ C = [0, 0] }}
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.C"]
angle = 0
[drivers.motor]
joint = "guide"
position = "{position}"
"""


def model(tables, position="lift(t)", head=""):
    return BLOCK.format(head=f"{head}\n[tables]\n{tables}", position=position)


def at(m, *times):
    return m.kinematics(list(times))["block.x"]


def test_points_may_have_units_parameters_and_a_common_unit():
    y = 'lift = { x = ["0 ms", 500, "1 s"], y = [0, "h/2", "h"], units = ["ms", ""] }'
    m = rt.loads(model(y, head='[parameters]\nh = "4 mm"'))
    np.testing.assert_allclose(at(m, 0.25, 0.75), [0.001, 0.003], rtol=1e-15)
    np.testing.assert_allclose(at(m.set(h="8 mm"), 0.75), [0.006], rtol=1e-15)
    np.testing.assert_allclose(at(m.set({"tables.lift.y": [0, 1, 3]}), 0.75), [2.0], rtol=1e-15)


def test_parameters_may_use_a_table_and_a_table_may_use_parameters():
    head = '[parameters]\nh = "2*first(0.5)"\n'
    tables = 'first = { x = [0, 1], y = ["0 mm", "4 mm"] }\nlift = { x = [0, 1], y = [0, "h"] }'
    assert rt.loads(model(tables, head=head)).parameters["h"] == pytest.approx(0.004, rel=1e-15)
    with pytest.raises(rt.ModelError, match="made with parameters, so parameters cannot be made with it"):
        rt.loads(model(tables, head='[parameters]\nh = "2*lift(0.5)"\n'))


def test_a_table_is_used_in_signals_loads_lengths_and_other_tables_arguments():
    head = '[parameters]\nm = "lift(lift(1))"\n[signals]\nhigh = "2*lift(t) - lift(0.5)"\n'
    m = rt.loads(model("lift = { x = [0, 1], y = [0, 0.5] }", head=head))
    assert m.parameters["m"] == 0.25
    assert m.kinematics([0.5])["high"][0] == 0.25


def test_a_parameter_uses_a_table_also_after_a_run():
    """A run has switched to machine code, which takes arrays."""
    text = model("lift = { x = [0, 1], y = [0, 0.5] }", head='[parameters]\nm = "lift(1)"\n')
    rt.loads(text).simulate(0.01)
    assert rt.loads(text).parameters["m"] == 0.5


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ("lift = 3", "expected a table { x = [...], y = [...] }, got 3"),
        ("lift = { x = [0, 1] }", "needs y: lists of numbers, or file"),
        ("lift = { x = [0, 1], y = [0, 1], z = 2 }", "unknown key"),
        ("lift = { x = [0, 1], y = 3 }", "expected a list of numbers, got 3"),
        ("lift = { x = [0, 1, 1], y = [0, 1, 2] }", "tables.lift.x[2]: 1 does not follow on 1: x must increase"),
        ("lift = { x = [0], y = [1] }", "1 point; a table needs two or more"),
        ("lift = { x = [0, 1, 2], y = [0, 1] }", "x has 3 numbers and y has 2; expected as many"),
        ("lift = { x = [0, inf], y = [0, 1] }", "inf is not a finite number"),
        ("lift = { x = [0, nan], y = [0, 1] }", "nan is not a finite number"),
        ("lift = { x = [0, 1], y = [0, true] }", "got true"),
        ('lift = { x = [0, 1], y = ["1 mm", "2 kg"] }', "'2 kg' is a mass, others are a length"),
        ('lift = { x = [0, 1], y = ["1 mm", "2 slug"] }', "unknown unit 'slug'"),
        ('lift = { x = [0, 1], y = [0, "b"] }', "unknown name 'b'"),
        ('lift = { x = [0, 1], y = [0, "t"] }', "only parameters are allowed here"),
        ('lift = { x = [0, 1], y = [0, 1], units = ["mm"] }', 'expected the units of x and y, as in ["deg", "mm"]'),
        ('lift = { x = [0, 1], y = [0, 1], units = ["", "mmm"] }', "unknown unit 'mmm'"),
        ('lift = { x = [0, 1], y = [0, 1], kind = "cubic" }', "expected one of linear, monotone, spline, got 'cubic'"),
        ("lift = { x = [0, 1, 2], y = [0, 1, 2], period = 2 }", "y ends with 2 one period after 0"),
        ("lift = { x = [0, 1, 2], y = [0, 1, 0], period = 1.5 }", "x goes over 2, more than the period 1.5"),
        ("lift = { x = [0, 1], y = [0, 1], period = 0 }", "must be positive"),
        ('lift = { x = ["0 s", "1 s"], y = [0, 1], period = "2 m" }', "is a length; x is a time"),
        ('lift = { x = [0, 1], y = [0, 1], kind = "spline", period = 2 }', "needs three or more different points"),
        (
            'lift = { x = [0, 1, 2], y = [0, 1, 0], kind = "spline", period = 2 }',
            "needs three or more different points",
        ),
        ("lift = { x = [0, 1e-50], y = [0, 1e50] }", "too large, or its points too close"),
        ("sin = { x = [0, 1], y = [0, 1] }", "'sin' is a function; choose another name"),
        ("floor = { x = [0, 1], y = [0, 1] }", "'floor' is a function; choose another name"),
        ("'a b' = { x = [0, 1], y = [0, 1] }", "is not a name"),
        ('lift = { file = "lift.csv" }', "a model that was not read from a file has no folder"),
        ('lift = { file = "../lift.csv" }', "tables.lift"),
        ('lift = { file = "lift.csv", x = [0, 1] }', "give a file or x and y, not both"),
        ("lift = { file = 3 }", "expected a file beside the model file"),
    ],
)
def test_what_is_no_table(tables, message):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(model(tables))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("position", "head", "message"),
    [
        ("lift", "", "'lift' is a table; write lift(x)"),
        ("lift(t, 2)", "", "lift takes 1 argument"),
        ("lft(t)", "", "there is no function 'lft'; did you mean 'lift'?"),
        ("lift(sqrt(block.x/9.81))", "", "a driver must depend on time only"),
        ("lift(3)*t", "", "3 is outside of the table 'lift', which goes from 0 to 2"),
        ("lift(t) + w", '[parameters]\nw = "1 kg"', "cannot add m and kg"),
        ("lift(w) + t", '[parameters]\nw = "1 kg"', "the table 'lift' is over s, not kg"),
        ("lift(t)", "[parameters]\nlift = 2", "the name 'lift' is already used in [parameters]"),
        ("lift(t)", '[signals]\nlift = "t"', "the name 'lift' is already used in [signals]"),
    ],
)
def test_what_a_table_cannot_do(position, head, message):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(model('lift = { x = ["0 s", "2 s"], y = ["0 mm", "5 mm"] }', position, head))
    assert message in str(caught.value)


# ---------------------------------------------------------------- files
CSV = "# measured\ntime [ms], lift [mm]\n\n0, 0\n500, 2.5\n1000, 5\n"


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "here"
    place.mkdir()
    (place / "lift.csv").write_text(CSV)
    (tmp_path / "outside.csv").write_text(CSV)
    return place


def load(folder, file, **files):
    (folder / "m.toml").write_text(model(f'lift = {{ file = "{file}", kind = "linear" }}  # from the bench'))
    return rt.load(folder / "m.toml")


def test_a_file_beside_the_model_is_read_with_the_units_of_its_header(folder):
    np.testing.assert_allclose(at(load(folder, "lift.csv"), 0.25, 0.75), [0.00125, 0.00375], rtol=1e-15)
    for text in ("0;0\n1;0.005\n", "\ufeffx\ty [mm]\n0\t0\n1\t5\n", "0, 0\n1, 0.005"):
        (folder / "lift.csv").write_text(text, encoding="utf-8")
        np.testing.assert_allclose(at(load(folder, "lift.csv"), 0.5), [0.0025], rtol=1e-15)


def test_a_file_outside_of_the_folder_is_refused(folder):
    for name in ("../outside.csv", "/etc/passwd", "sub/../../outside.csv", "C:\\\\lift.csv", "..\\\\outside.csv"):
        with pytest.raises(rt.ModelError, match="leads out of the folder of the model"):
            load(folder, name)
    (folder / "link.csv").symlink_to(folder.parent / "outside.csv")
    with pytest.raises(rt.ModelError, match="is a link out of the folder of the model"):
        load(folder, "link.csv")
    (folder / "inner.csv").symlink_to(folder / "lift.csv")
    assert at(load(folder, "inner.csv"), 0.5) == pytest.approx(0.0025)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "there is no file 'bad.csv' in the folder of the model"),
        ("x, y\n0, 0\n1, a\n", "bad.csv, line 3: 'a' is not a finite number"),
        ("x, y\n0, 0\n1, nan\n", "bad.csv, line 3: 'nan' is not a finite number"),
        ("x, y\n0, 0\n1, 2, 3\n", "bad.csv, line 3: expected two columns, found 3"),
        ("0 0\n1 1\n", "bad.csv, line 1: expected two columns, found 1"),
        ("x [mmm], y\n0, 0\n1, 1\n", "bad.csv, line 1: unknown unit 'mmm'"),
        ("x [mm, y\n0, 0\n1, 1\n", "bad.csv, line 1: expected a header such as 'lift [mm]'"),
        ("x, y\n", "'bad.csv' holds no numbers"),
        ("x, y\n1, 0\n0, 1\n", "0 does not follow on 1"),
        (b"\xff\xfe0", "'bad.csv' is not UTF-8 text"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_with_its_line(folder, text, message):
    if text is not None:
        (folder / "bad.csv").write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(rt.ModelError) as caught:
        load(folder, "bad.csv")
    assert message in str(caught.value)
    assert "m.toml:" in str(caught.value)


def test_a_saved_model_finds_its_file_or_holds_its_numbers(folder, tmp_path):
    m = load(folder, "lift.csv")
    assert rt.loads(m.to_toml()).kinematics([0.5])["block.x"][0] == pytest.approx(0.0025)
    for name in ("again.toml", "again.json"):
        m.save(folder / name)
        assert "lift.csv" in (folder / name).read_text()
        m.save(tmp_path / name)
        assert "lift.csv" not in (tmp_path / name).read_text()
        for place in (folder, tmp_path):
            assert at(rt.load(place / name), 0.5) == pytest.approx(0.0025)
    assert "# from the bench" in (folder / "again.toml").read_text()


def test_a_table_can_be_set(folder):
    m = load(folder, "lift.csv")
    (folder / "other.csv").write_text("0, 0\n1, 1\n")
    for other in (
        m.set({"tables.lift.file": "other.csv"}),
        m.set({"tables.lift": {"x": [0, 1], "y": [0, 1]}}),
        m.set({"tables.lift.y": [0, 500, 1000]}),
        rt.loads(m.set({"tables.lift.file": "other.csv"}).to_toml()),
    ):
        assert at(other, 0.25) == pytest.approx(0.25)
    assert at(m.set({"tables.lift.kind": "spline"}), 0.25) == pytest.approx(0.00125)
    with pytest.raises(rt.ModelError, match="leads out of the folder"):
        m.set({"tables.lift.file": "../outside.csv"})


def test_a_table_is_made_in_code():
    m = rt.Mechanism().ground(O=[0, 0]).body("block", points={"C": [0, 0]}, mass=1, inertia=1)
    m.prismatic("guide", "ground.O", "block.C").driver("motor", "guide", position="lift(t)")
    m.table("lift", np.linspace(0, 1, 3), ["0 mm", "5 mm", "0 mm"], kind="spline", period=2)
    assert at(m, 2.5) == pytest.approx(0.005)
    assert at(rt.loads(m.to_toml()), 2.5) == pytest.approx(0.005)
    with pytest.raises(rt.ModelError, match="the name 'lift' is taken"):
        m.table("lift", [0, 1], [0, 1])


# ---------------------------------------------------------------- leaving a table
def test_a_run_that_leaves_a_table_stops_and_says_where():
    m = rt.loads(model('lift = { x = [0, 1, 2], y = ["0 mm", "5 mm", "0 mm"], kind = "spline" }', "lift(2*t)"))
    r = m.kinematics(np.linspace(0.0, 1.0, 11))
    assert r.success
    r = m.kinematics(np.linspace(0.0, 2.0, 21))
    assert not r.success
    assert r.t[-1] <= 1.0
    assert "outside of the table 'lift', which goes from 0 to 2" in r.message
    for run in (m.simulate(2.0), m.simulate(2.0, method="rk4", step=0.01)):
        assert not run.success
        assert 0.98 < run.t[-1] <= 1.0 + 1e-9
        assert "outside of the table 'lift'" in run.message
    with pytest.raises(rt.AssemblyError, match="outside of the table 'lift'"):
        m.set({"drivers.motor.position": "lift(2*t - 1)"}).simulate(1.0)
