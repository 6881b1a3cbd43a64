"""Mechanisms of pylinkage: the same places at the same steps, and what the file does not say is told."""

import json
import math

import numpy as np
import pytest

import rattle as rt
from foreign_texts import pylinkage
from rattle.exchange.imported import Assumptions
from rattle.exchange.pylinkage.read import read_pylinkage
from rattle.exchange.writing import text_of


def imported(text: str, **stated):
    return read_pylinkage(text, "a.json", Assumptions(**stated))


def mechanism(text: str, **stated):
    return rt.loads(text_of(imported(text, **stated)))


def changed(change) -> str:
    document = json.loads(pylinkage())
    change(document)
    return json.dumps(document)


def circles(p, r, q, s, near):
    """The point at the distances r from p and s from q that is nearer to `near`."""
    p, q = np.array(p), np.array(q)
    d = np.hypot(*(q - p))
    a = (r * r - s * s + d * d) / (2 * d)
    foot, h = p + a * (q - p) / d, math.sqrt(r * r - a * a) / d
    both = [foot + sign * h * np.array([-(q - p)[1], (q - p)[0]]) for sign in (1, -1)]
    return min(both, key=lambda point: np.hypot(*(point - near)))


def test_a_four_bar_goes_through_the_places_of_its_steps():
    steps = np.arange(40)
    r = mechanism(pylinkage()).kinematics(steps / 25)
    near, rod, rocker = np.array([3.0, 2.0]), math.hypot(3, 1), math.hypot(1, 2)
    for k in steps:
        a = math.pi / 2 + k * math.tau / 100
        pin = np.array([math.cos(a), math.sin(a)])
        near = circles(pin, rod, (4, 0), rocker, near)
        assert (r["rod.B.x"][k], r["rod.B.y"][k]) == pytest.approx(tuple(near), abs=1e-12)
        along = (near - pin) / rod
        angle = math.pi / 4 - math.atan2(1, 3)
        c, s = math.cos(angle), math.sin(angle)
        tracked = pin + math.sqrt(2) * np.array([c * along[0] - s * along[1], s * along[0] + c * along[1]])
        assert (r["rod.T.x"][k], r["rod.T.y"][k]) == pytest.approx(tuple(tracked), abs=1e-12)


def test_links_are_uniform_bars_and_this_is_told():
    read = imported(pylinkage())
    assert read.document["bodies"]["crank"] == {"bar": ["O", "pin"], "length": 1.0, "mass": 1.0}
    told = " ".join(read.assumed)
    assert all(word in told for word in ("1 m", "kg/m", "25 steps", "--scale", "--steps-per-second"))


def test_a_unit_and_the_steps_of_a_second_can_be_stated():
    m = mechanism(pylinkage(), scale=0.01, steps_per_second=100.0)
    r = m.kinematics([0.0])
    assert r["crank.omega"][0] == pytest.approx(math.tau, rel=1e-14)
    assert m.model.bodies["rocker"].mass == pytest.approx(0.01 * math.sqrt(5), rel=1e-14)
    assert (r["rod.B.x"][0], r["rod.B.y"][0]) == pytest.approx((0.03, 0.02), abs=1e-15)


def test_the_motor_may_be_at_either_end_of_a_link():
    turned = mechanism(changed(lambda d: d["links"][1].update(joints=["A", "O"]))).kinematics([0.0, 0.3])
    plain = mechanism(pylinkage()).kinematics([0.0, 0.3])
    np.testing.assert_allclose(turned["rod.B.x"], plain["rod.B.x"], atol=1e-14)
    np.testing.assert_allclose(turned["crank.angle"], plain["crank.angle"], atol=1e-14)


def test_a_driver_begins_at_its_initial_angle():
    read = imported(changed(lambda d: d["links"][1].update(initial_angle=1.2)))
    r = rt.loads(text_of(read)).kinematics([0.0])
    assert r["crank.angle"][0] == pytest.approx(1.2, abs=1e-12)
    assert any("crank" in word and "initial_angle" in word for word in read.taken)


def arc(start: float, end: float, initial: float, rate: float) -> str:
    return changed(
        lambda d: d["links"][1].update(
            type="arc_driver", arc_start=start, arc_end=end, initial_angle=initial, angular_velocity=rate
        )
    )


@pytest.mark.parametrize(("initial", "rate"), [(1.2, 0.05), (1.0, 0.05), (1.6, 0.05), (1.55, 0.05), (1.3, -0.05)])
def test_an_arc_driver_turns_back_at_its_ends(initial, rate):
    t = np.linspace(0, 3, 61)
    r = mechanism(arc(1.0, 1.6, initial, rate)).kinematics(t)
    angle, direction, want = initial, 1.0, []
    for step in range(3 * 25 * 1000 + 1):  # by small steps, as the program does by large ones
        if step % 1250 == 0:
            want.append(angle)
        angle += direction * rate / 1000
        if (angle > 1.6 and direction * rate > 0) or (angle < 1.0 and direction * rate < 0):
            angle, direction = (3.2 if angle > 1.6 else 2.0) - angle, -direction
    np.testing.assert_allclose(r["crank.angle"], want, atol=1e-9)
    assert abs(r["crank.omega"][0]) == pytest.approx(abs(rate) * 25, rel=1e-12)


def test_a_link_of_three_joints_is_a_body_of_three_bars():
    def change(document):
        document["joints"].append({"id": "P", "type": "revolute", "position": [2.0, 3.0]})
        document["links"][2]["joints"].append("P")

    m = mechanism(changed(change))
    corners = np.array([(0, 1), (3, 2), (2, 3)], float)
    middle, length = (corners + np.roll(corners, -1, 0)) / 2, np.hypot(*(corners - np.roll(corners, -1, 0)).T)
    centre = length @ middle / length.sum()
    inertia = sum(n * (n * n / 12 + np.sum((p - centre) ** 2)) for n, p in zip(length, middle, strict=True))
    assert (m.model.bodies["rod"].mass, m.model.bodies["rod"].inertia) == pytest.approx(
        (length.sum(), inertia), rel=1e-13
    )
    r = m.kinematics([0.0])
    assert (r["rod.x"][0], r["rod.y"][0]) == pytest.approx(tuple(centre), abs=1e-13)


def test_where_three_links_meet_there_are_two_pins():
    def change(document):
        document["joints"] += [
            {"id": "E", "position": [5.0, 3.0]},
            {"id": "F", "type": "ground", "position": [7.0, 0.0]},
        ]
        document["links"] += [{"id": "BE", "joints": ["B", "E"]}, {"id": "EF", "joints": ["E", "F"]}]

    table = imported(changed(change)).document["joints"]
    assert [entry["connect"] for name, entry in table.items() if name.startswith("B")] == [
        ["rod.B", "rocker.B"],
        ["rod.B", "BE.B"],
    ]
    assert len(table) == 7


def test_a_slider_stays_on_its_line():
    def change(document):
        document["joints"][2].update(type="prismatic", axis=[2.0, 1.0], line_point=[1.0, 1.0])
        del document["links"][3], document["joints"][3]
        document["links"][0]["joints"].remove("D")

    r = mechanism(changed(change)).kinematics(np.linspace(0, 2, 9))
    np.testing.assert_allclose(r["rod.B.y"] - 1, (r["rod.B.x"] - 1) / 2, atol=1e-12)


def test_a_tracker_may_refer_to_a_tracker_or_stand_in_the_ground():
    def change(document):
        document["joints"] += [
            {
                "id": "U",
                "type": "tracker",
                "position": [0, 0],
                "ref_joint1_id": "T",
                "ref_joint2_id": "B",
                "distance": 1.0,
            },
            {
                "id": "V",
                "type": "tracker",
                "position": [0, 0],
                "ref_joint1_id": "pin",
                "ref_joint2_id": "D",
                "distance": 1.0,
            },
            {"id": "W", "type": "tracker", "position": [9.0, 9.0]},
        ]
        document["joints"][-2]["ref_joint1_id"] = "A"

    read = imported(changed(change))
    r = rt.loads(text_of(read)).kinematics([0.0])
    assert (r["rod.U.x"][0], r["rod.U.y"][0]) == pytest.approx((2.0, 2.0), abs=1e-12)
    assert any("V" in word for word in read.left_out)


def test_links_that_cannot_move_are_left_out_by_name():
    def change(document):
        document["links"] += [{"id": "wall", "joints": ["O", "D"]}, {"id": "stub", "joints": ["B"]}]

    left = " ".join(imported(changed(change)).left_out)
    assert "wall" in left
    assert "stub" in left


def set_in(path, value):
    def change(document):
        place = document
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value

    return changed(change)


@pytest.mark.parametrize(("path", "value", "says"), [
    (("links", 2, "joints", 1), "X", "links[2].joints[1]"), (("links", 1, "motor_joint"), "X", "links[1].motor_joint"),
    (("links", 1, "motor_joint"), "B", "crank"), (("joints", 4, "ref_joint1_id"), "X", "joints[4].ref_joint1_id"),
    (("ground",), "X", "ground"), (("joints", 1, "type"), "spherical", "spherical"),
    (("joints", 1, "type"), "Crank", "older"), (("links", 1, "type"), "cam", "cam"),
    (("joints", 1, "position"), [None, None], "joints[1].position"),
    (("joints", 1, "position"), [0, "1"], "joints[1].position[1]"),
    (("joints", 1, "position"), [0, 1e300], "joints[1].position[1]"),
    (("joints", 1, "id"), "O", "two joints"), (("links", 1, "id"), "rod", "two links"),
    (("joints", 1, "id"), 7, "joints[1].id"), (("joints",), {}, "joints"), (("links",), [], "links"),
    (("links", 0), 3, "links[0]"), (("links", 1, "angular_velocity"), None, "links[1]"),
    (("joints", 1, "position"), [0.0, 0.0], "crank"), (("links", 1, "joints"), "OA", "links[1].joints"),
])  # fmt: skip
def test_what_cannot_be_read_is_refused_by_its_place(path, value, says):
    with pytest.raises(rt.ModelError) as caught:
        imported(set_in(path, value))
    assert str(caught.value).startswith("a.json: ")
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", [
    pylinkage()[:200], pylinkage().replace("1.0", "NaN", 1), pylinkage().replace("1.0", "1" + "0" * 5000, 1), "{}",
    '{"a": ' * 2000, pylinkage().replace('"joints"', '"joint"'), '{"joints": [{"id": "A", "id": "B"}]}',
])  # fmt: skip
def test_broken_json_is_refused_in_one_line(text):
    with pytest.raises(rt.ModelError, match=r"^a\.json[^\n]+$"):
        imported(text)
