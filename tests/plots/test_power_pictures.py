"""Pictures of power: energy that enters a body on the sheet leaves it, and everything has its place and name."""

import numpy as np
import pytest

import rattle as rt
from rattle.questions.power.flows import graph_of, lay_out


@pytest.fixture(scope="module")
def powers():
    """A machine with gravity, cylinders between bodies and loops; and one whose energy comes back."""
    excavator = rt.example("excavator").simulate(0.5).power()
    return {"excavator": excavator, "fourbar": rt.example("fourbar").ideal().simulate(0.7).power()}


@pytest.mark.parametrize("name", ["excavator", "fourbar"])
def test_energy_that_enters_a_body_leaves_it(powers, name):
    nodes, links = graph_of(powers[name])
    largest = max(link.net + link.back for link in links)
    for k, node in enumerate(nodes):
        if node.body >= 0:
            change = sum(link.net * ((link.end == k) - (link.start == k)) for link in links)
            assert abs(change) <= 2e-3 * largest * len(links)  # thinner links are left out
    assert sum(node.side == "body" for node in nodes) == len(set(powers[name].names["body"]))


@pytest.mark.parametrize("name", ["excavator", "fourbar"])
def test_bands_lead_from_column_to_column(powers, name):
    sheet = lay_out(*graph_of(powers[name]))
    for link, ends in zip(sheet.links, sheet.ends, strict=True):
        assert abs(sheet.x[link.end] - sheet.x[link.start]) == 1
        assert abs(ends[1][0] - ends[0][0]) > 0.9  # none is drawn inside of a column
    for c in range(sheet.columns):
        inside = np.flatnonzero(sheet.x == c)
        order = inside[np.argsort(sheet.y[inside])]
        bottom, top = sheet.y[order] - 0.5 * sheet.heights[order], sheet.y[order] + 0.5 * sheet.heights[order]
        assert (bottom[1:] > top[:-1]).all()


def test_the_sheet_names_what_gives_and_takes(powers):
    (ax,) = powers["excavator"].plot().axes
    said = " ".join(one.get_text() for one in ax.texts)
    for word in ("boom", "bucket", "gravity", "lift", "crowd", "J"):
        assert word in said


def test_a_mechanism_at_rest_has_an_empty_sheet():
    still = rt.example("fourbar").ideal().set({"drivers.motor.angle": 0, "loads.M": None, "gravity": [0, 0]})
    (ax,) = still.simulate(0.1).power().plot().axes
    assert "no energy is exchanged" in " ".join(one.get_text() for one in ax.texts)


def test_curves_of_a_body_add_up_to_its_kinetic_energy(powers):
    figure = powers["fourbar"].plot_curves()
    assert [ax.get_ylabel() for ax in figure.axes] == ["crank [W]", "coupler [W]", "rocker [W]"]
    for ax in figure.axes:
        curves = {line.get_label(): line.get_ydata() for line in ax.lines if len(line.get_ydata()) > 2}
        total = curves.pop("kinetic energy")
        assert sum(curves.values()) == pytest.approx(total, abs=1e-6)


def test_arrows_point_where_power_goes():
    """At 0.3 s the moment drives the motor backwards: from rocker to coupler, crank and out of the mechanism."""
    from rattle.plots.animation import scene

    r = rt.example("fourbar").ideal().simulate(0.3, t_eval=[0.0, 0.3])
    figure, update, count = scene(r, 2, power=True)
    update(count - 1)
    arrows = [one.get_xy() for one in figure.axes[0].patches if one.get_visible() and len(one.get_xy()) == 8]
    names = ("crank", "coupler", "rocker")
    crank, coupler, rocker = (np.array([r[f"{name}.x"][-1], r[f"{name}.y"][-1]]) for name in names)
    ways = [corners[3] - 0.5 * (corners[0] + corners[6]) for corners in arrows]
    for way in (crank - coupler, coupler - rocker):
        along = way / np.hypot(*way)
        assert any(one @ along > 0.999 * np.hypot(*one) for one in ways)
        assert not any(one @ along < -0.999 * np.hypot(*one) for one in ways)


def told(p):
    """The texts of the sheet by their first word; a node has one line for each of its words."""
    (ax,) = p.plot().axes
    texts = [one.get_text().replace("\n", "  ") for one in ax.texts]
    return {text.split("  ")[0]: text.split("  ")[1:] for text in texts}


def test_an_ideal_cycle_tells_what_goes_back_and_forth():
    """What the motor gives, and takes again, is the integral of its power where this is positive."""
    r = rt.example("slider_crank").simulate(t_eval=np.linspace(0.0, 0.024, 8001))
    p, power = r.power(), np.maximum(r["motor.power"], 0.0)
    last = r.t >= p.t0 - 1e-12
    energy = np.trapezoid(power[last], r.t[last])
    texts = told(p)
    assert texts["motor"] == texts["A"] == [f"⇄ {energy:.3g} J"]
    assert not any(" 0 J" in f" {text}" for words in texts.values() for text in words)
    recirculated = p.elements.set_index("element").recirculated
    assert [recirculated["motor"], recirculated["A"]] == pytest.approx([energy] * 2, rel=1e-4)
    assert recirculated["O"] == pytest.approx(0.0, abs=1e-9)


def test_a_motor_that_has_given_almost_as_much_as_it_took_stands_on_the_left():
    p = rt.example("crank_rocker_play").simulate().power()  # its start is not quite its end
    assert -1e-3 < p.table.set_index("element").net["motor"] / p.recirculated.max() < 0.0
    assert "motor" in [node.name for node in graph_of(p)[0] if node.side == "source"]


def test_a_spring_on_the_way_tells_what_it_lends():
    """Twice in a turn it is at rest: before and behind its free length of 0.1 m, up to 70 and 30 mm away."""
    spring = {"type": "spring", "connect": ["ground.O", "slider"], "stiffness": 2000, "free_length": 0.1}
    p = rt.example("slider_crank").set({"loads.s": spring}).simulate().power()
    assert told(p)["s"] == ["⇄ 5.8 J"]  # 2000/2*(0.07**2 + 0.03**2)
    assert p.elements.set_index("element").recirculated["s"] == pytest.approx(5.8, rel=1e-6)


def test_friction_tells_its_loss_beside_what_goes_back_and_forth():
    p = rt.example("slider_crank").set({"joints.guide.friction": 0.1}).simulate().power()
    lost = p.elements.set_index("element").lost["guide"]
    texts = told(p)
    assert texts["guide"] == [f"{lost:.3g} J"]
    assert texts["motor"][0] == texts["B"][0] == f"{lost:.3g} J"
    assert texts["motor"][1].startswith("⇄ ")


def test_energies_stand_apart_in_crowded_sheets(powers):
    figure = powers["excavator"].plot()
    (ax,) = figure.axes
    figure.canvas.draw()
    boxes = [one.get_window_extent() for one in ax.texts if "  " in one.get_text()]
    assert len(boxes) > 5
    assert not any(one.overlaps(other) for k, one in enumerate(boxes) for other in boxes[:k])
