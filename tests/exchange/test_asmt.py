"""Assemblies of Ondsel and FreeCAD: what moves in their plane moves so here, wherever the plane is in space."""

import math
import re
import tomllib
from itertools import pairwise

import numpy as np
import pytest

import foreign_texts as foreign
import rattle as rt
from foreign_texts import Assembly, about_z, rotation
from rattle.exchange.asmt.motion_text import MotionTextError, model_expression
from rattle.exchange.asmt.read import read_asmt
from rattle.exchange.imported import Assumptions
from rattle.exchange.writing import text_of
from rattle.language.expression import Number, parse, replaced, value

TURNED = rotation((1, 0, 0), math.pi)  # z points away
SPACES = {
    "as drawn": np.eye(3),
    "upright in xz": rotation((1, 0, 0), math.pi / 2),
    "from behind": rotation((1, 0, 0), -math.pi / 2),
    "in yz": rotation((0, 1, 0), math.pi / 2),
    "anywhere": rotation((1, 2, 3), 1.1),
    "tilted": rotation((1, 1, 0), 0.4),
}


def imported(drawing: Assembly, **stated):
    return read_asmt(drawing.text(), "drawing.asmt", Assumptions(**stated))


def mechanism(drawing: Assembly, **stated):
    return rt.loads(text_of(imported(drawing, **stated)))


def errors(m) -> list[float]:
    """How far torque and forces of the four-bar are from those that its file stores [N m, N]."""
    r = m.inverse_dynamics(list(foreign.STORED))
    want = np.array(list(foreign.STORED.values())).T
    off = [np.abs(np.abs(r["Motion1.torque"]) - np.abs(want[0])).max()]
    for k in range(4):  # stored on the part of marker I, here on that of marker J
        for n, way in enumerate("xy"):
            off.append(np.abs(r[f"Joint{k + 1}.f{way}"] + want[1 + 2 * k + n]).max())
    return off


@pytest.mark.parametrize("space", SPACES)
def test_forces_are_those_that_ondsel_stored_wherever_the_plane_is(space):
    m = mechanism(foreign.fourbar(SPACES[space], (0.3, -2, 5) if space != "as drawn" else (0, 0, 0)))
    assert max(errors(m)) < 1e-9  # 14 digits of 27 N; own loop closure and Newton-Euler agree with the file to 6e-11 N


@pytest.mark.parametrize(("axes", "sense"), [(about_z(0.7), ""), (TURNED, "-"), (about_z(2) @ TURNED, "-")])
def test_the_axes_of_markers_say_where_a_motor_begins_and_which_way_it_turns(axes, sense):
    drawing = foreign.fourbar(marker=axes)
    drawing.motions.clear()
    drawing.turn("Motion1", "Joint1", f"{sense}2.0d*pi*time")
    assert max(errors(mechanism(drawing))) < 1e-9


def test_x_and_y_stay_where_the_axes_point_away():
    m = mechanism(foreign.fourbar(rotation((0, 1, 0), math.pi)))
    plain = mechanism(foreign.fourbar())
    a, b = m.inverse_dynamics([0.0, 0.3]), plain.inverse_dynamics([0.0, 0.3])
    np.testing.assert_allclose(a["Joint2.fx"], -b["Joint2.fx"], rtol=1e-10)
    np.testing.assert_allclose(a["Joint2.fy"], b["Joint2.fy"], rtol=1e-10)
    assert m.to_toml().count("gravity = [0.0, -9.81]") == 1


def test_a_marker_stands_in_a_point_that_is_turned_itself():
    drawing = foreign.fourbar()
    at, turn, mass, moments, centre, markers, rates = drawing.parts["Part2"]
    place, inner = np.array([0.2, -0.3, 0.7]), rotation((1, 1, 2), 0.8)
    moved = {
        name: (inner.T @ (np.array(spot) - place), inner.T @ axes, (place, inner))
        for name, (spot, axes, _) in markers.items()
    }
    drawing.parts["Part2"] = (at, turn, mass, moments, centre, moved, rates)
    assert max(errors(mechanism(drawing))) < 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_the_frames_in_which_parts_are_written_do_not_matter(seed):
    rng = np.random.default_rng(seed)
    drawing = foreign.fourbar(rotation(rng.normal(size=3), 2.0), rng.normal(size=3))
    for name, (at, turn, mass, moments, (spot, axes), markers, rates) in drawing.parts.items():
        own, shift = rotation(rng.normal(size=3), rng.uniform(-3, 3)), rng.normal(size=3)  # of the part's new frame
        turned = {
            word: (
                own.T @ (np.array(place) - shift),
                own.T @ frame @ about_z(0.0 if name == "Part1" else rng.normal()),
                None,
            )
            for word, (place, frame, _) in markers.items()
        }
        centre = (own.T @ (np.array(spot) - shift), own.T @ axes)
        drawing.parts[name] = (at + turn @ shift, turn @ own, mass, moments, centre, turned, rates)
    assert max(errors(mechanism(drawing))) < 1e-9


@pytest.mark.parametrize("rewritten", [
    lambda text: text.replace("\t", "    "),
    lambda text: text.replace(" \t", "\t"),
    lambda text: re.sub(r"(?<=\d) \t", "  ", text).replace("\n", "\r\n"),
    lambda text: "\ufeff" + text,
])  # fmt: skip
def test_tabs_or_blanks_mean_the_same(rewritten):
    text = foreign.fourbar().text()
    plain, other = (read_asmt(word, "f.asmt", Assumptions()).document for word in (text, rewritten(text)))
    assert plain == other


def test_the_moment_of_inertia_is_that_about_the_normal():
    drawing, axes, moments = foreign.fourbar(SPACES["anywhere"]), rotation((3, 1, 2), 0.9), (0.03, 0.05, 0.07)
    at, turn, mass, _, (spot, _), markers, rates = drawing.parts["Part2"]
    drawing.parts["Part2"] = (at, turn, mass, moments, (spot, axes), markers, rates)
    tensor = axes @ np.diag(moments) @ axes.T
    assert mechanism(drawing).model.bodies["Part2"].inertia == pytest.approx(tensor[2, 2], rel=1e-12)


def slider_crank(kind: str, turned: float = 0.0, frame=None) -> Assembly:
    """Crank 0.2 m, rod 0.5 m, piston on the line at `turned` [rad] through the axis of the crank."""
    along = rotation((0, 1, 0), math.pi / 2)  # z of the marker along x
    drawing, line = Assembly(frame=frame), about_z(turned)
    drawing.marker("O", (0, 0, 0))
    drawing.marker("Line", line @ (0.3, 0, 0), line @ along)
    end = 0.2 * 0 + math.sqrt(0.5**2 - 0.2**2)
    rod = math.atan2(-0.2, end) + turned
    moments, flat = (1e-3, 1e-3, 2e-3), np.eye(3)
    drawing.part("Crank", (0, 0, 0), about_z(math.pi / 2 + turned), 1.0, moments, ((0.1, 0, 0), flat),
                 {"O": ((0, 0, 0), flat, None), "A": ((0.2, 0, 0), flat, None)})  # fmt: skip
    drawing.part("Rod", line @ (0, 0.2, 0), about_z(rod), 2.0, moments, ((0.25, 0, 0), flat),
                 {"A": ((0, 0, 0), flat, None), "B": ((0.5, 0, 0), flat, None)})  # fmt: skip
    drawing.part("Piston", line @ (end, 0, 0), about_z(1.0), 3.0, moments, ((0, 0, 0), flat),
                 {"B": ((0, 0, 0), flat, None), "Line": ((0, 0, 0), about_z(turned - 1.0) @ along, None)})  # fmt: skip
    for name, i, j in (("J1", "O", "Crank/O"), ("J2", "Crank/A", "Rod/A"), ("J3", "Rod/B", "Piston/B")):
        drawing.joint("RevoluteJoint", name, i, j)
    drawing.joint(kind, "J4", "Line", "Piston/Line")
    return drawing


@pytest.mark.parametrize("kind", ["TranslationalJoint", "CylindricalJoint"])
@pytest.mark.parametrize(("turned", "space"), [(0.0, "as drawn"), (0.7, "tilted")])
def test_a_piston_moves_as_the_closed_form_says(kind, turned, space):
    drawing = slider_crank(kind, turned, SPACES[space])
    drawing.turn("Motor", "J1", f"pi/2 + {turned!r} + 3.0d*time")
    t = np.linspace(0, 2, 9)
    m = mechanism(drawing)
    r = m.kinematics(t)
    a = math.pi / 2 + 3 * t
    want = 0.2 * np.cos(a) + np.sqrt(0.5**2 - (0.2 * np.sin(a)) ** 2)
    np.testing.assert_allclose(np.hypot(r["Piston.x"], r["Piston.y"]), want, atol=1e-12)
    np.testing.assert_allclose(r["Piston.angle"], r["Piston.angle"][0], atol=1e-12)
    told = " ".join(imported(drawing).taken)
    assert ("does not turn about it" in told) == (kind == "CylindricalJoint")


def test_a_slider_that_is_moved_goes_as_far_as_it_is_told():
    drawing = slider_crank("TranslationalJoint")
    drawing.motions.append(["TranslationalMotion", "\tName", "\t\tPush", "\tMotionJoint", "\t\t/Assembly1/J4",
                            "\tTranslationZ", "\t\t0.1d*time + 0.1d"])  # fmt: skip
    r = mechanism(drawing).kinematics([0.0, 1.0, 2.5])
    np.testing.assert_allclose(r["Piston.x"], 0.4 + 0.1 * r.t, atol=1e-12)


def test_a_cylindrical_joint_along_the_normal_turns_and_this_is_told():
    drawing = foreign.fourbar()
    drawing.joints[2] = ("CylindricalJoint", *drawing.joints[2][1:])
    assert max(errors(mechanism(drawing))) < 1e-9
    assert any("Joint3" in word and "slide" in word for word in imported(drawing).taken)


def test_a_cylindrical_joint_in_the_plane_is_driven_along_it_and_not_about_it():
    drawing, words = slider_crank("CylindricalJoint"), ["\tName", "\t\tM", "\tMotionJoint", "\t\t/Assembly1/J4"]
    drawing.motions = [["TranslationalMotion", *words, "\tTranslationZ", "\t\t0.1d + time^2"]]
    r = mechanism(drawing).kinematics([0.0, 0.4])
    np.testing.assert_allclose(r["Piston.x"], [0.4, 0.56], atol=1e-12)
    drawing.motions = [["RotationalMotion", *words, "\tRotationZ", "\t\ttime"]]
    assert "M: it turns a joint that cannot turn" in refusal(drawing.text())


def test_parts_without_mass_are_told():
    drawing = foreign.fourbar()
    drawing.parts["Part2"] = (*drawing.parts["Part2"][:2], 0.0, (0, 0, 0), *drawing.parts["Part2"][4:])
    assert any("Part2" in word and "no mass" in word for word in imported(drawing).taken)


def test_parts_that_are_fixed_to_each_other_move_as_one():
    drawing = foreign.fourbar()
    at, turn, mass, moments, centre, markers, rates = drawing.parts["Part2"]
    axes = rotation((1, 0, 0), 0.6)
    markers = markers | {"Seat": ((0.4, 0.5, 0), axes, None)}
    drawing.parts["Part2"] = (at, turn, mass, moments, centre, markers, rates)
    own = about_z(1.3)  # of the weight in the coupler, whose seat is at its own (0.1, 0, 0)
    spot = np.array(at) + turn @ ((0.4, 0.5, 0) - own @ (0.1, 0, 0))
    weight = {"Seat": ((0.1, 0, 0), own.T @ axes, None)}
    drawing.part("Weight", spot, turn @ own, 0.5, (0, 0, 0.001), ((0.2, 0, 0), np.eye(3)), weight)
    drawing.joint("FixedJoint", "Weld", "Part2/Seat", "Weight/Seat")
    r = mechanism(drawing).kinematics([0.0, 0.3, 0.8])
    np.testing.assert_allclose(r["Weight.angle"] - r["Part2.angle"], 1.3, atol=1e-12)
    local = np.array([0.4, 0.5]) + own[:2, :2] @ [0.1, 0] - np.array([1.0, 0.1])  # mass centres
    c, s = np.cos(r["Part2.angle"]), np.sin(r["Part2.angle"])
    np.testing.assert_allclose(r["Weight.x"] - r["Part2.x"], c * local[0] - s * local[1], atol=1e-12)


def wheels(radii, distance: float = 3.0) -> Assembly:
    """Two wheels about axes of the ground; the first is turned."""
    drawing, flat = Assembly(), np.eye(3)
    for n, x in enumerate((0.0, distance), 1):
        drawing.marker(f"O{n}", (x, 0, 0))
        drawing.part(
            f"Wheel{n}",
            (x, 0, 0),
            about_z(0.4 * n),
            1.0,
            (0.1, 0.1, 0.2),
            ((0, 0, 0), flat),
            {"O": ((0, 0, 0), flat, None)},
        )
        drawing.joint("RevoluteJoint", f"J{n}", f"O{n}", f"Wheel{n}/O")
    drawing.joint("GearJoint", "Mesh", "Wheel1/O", "Wheel2/O", radiusI=radii[0], radiusJ=radii[1])
    drawing.turn("Motor", "J1", "0.4 + 2*time")
    return drawing


@pytest.mark.parametrize(("radii", "distance", "ratio"), [
    ((1.0, 2.0), 3.0, -0.5), ((1.0, 2.0), 4.5, -0.5), ((4.0, -1.0), 3.0, 4.0), ((-1.0, 4.0), 3.0, 0.25),
])  # fmt: skip
def test_wheels_turn_in_the_ratio_of_their_radii(radii, distance, ratio):
    r = mechanism(wheels(radii, distance)).kinematics([0.0, 0.7])
    np.testing.assert_allclose(r["Wheel2.omega"], 2 * ratio, rtol=1e-12)


@pytest.mark.parametrize("radius", [0.5, -0.5])
@pytest.mark.parametrize("axes", [np.eye(3), TURNED])
def test_a_rack_moves_as_the_rule_of_the_solver_says(radius, axes):
    # x of J in I + R theta = constant, theta: of J relative to I about z of I
    drawing, flat, along = Assembly(), np.eye(3), rotation((0, 1, 0), math.pi / 2)
    drawing.marker("O", (0, 1, 0))
    drawing.marker("Line", (0, 0, 0), along)
    drawing.part("Rack", (0, 0, 0), flat, 1.0, (0.1, 0.1, 0.2), ((0, 0, 0), flat),
                 {"I": ((0, 0, 0), axes, None), "Line": ((0, 0, 0), along, None)})  # fmt: skip
    drawing.part("Pinion", (0, 1, 0), flat, 1.0, (0.1, 0.1, 0.2), ((0, 0, 0), flat),
                 {"O": ((0, 0, 0), flat, None), "J": ((0, 0, 0), axes, None)})  # fmt: skip
    drawing.joint("RevoluteJoint", "Axle", "O", "Pinion/O")
    drawing.joint("TranslationalJoint", "Guide", "Line", "Rack/Line")
    drawing.joint("RackPinionJoint", "Mesh", "Rack/I", "Pinion/J", pitchRadius=radius)
    drawing.turn("Motor", "Axle", "2*time")
    r = mechanism(drawing).kinematics([0.0, 0.3])
    sense = axes[2, 2]  # of z
    x = -r["Rack.x"] * axes[0, 0]  # of the pinion, seen from the rack
    np.testing.assert_allclose(x + radius * sense * r["Pinion.angle"], 0.0, atol=1e-12)
    assert max(abs(r["Rack.x"])) == pytest.approx(0.3, rel=1e-12)


def pendulum(rates=((0, 0, 0), (0, 0, 0))) -> Assembly:
    drawing, flat = Assembly(), np.eye(3)
    drawing.marker("O", (0, 0, 0))
    drawing.part(
        "Arm",
        (0, 0, 0),
        about_z(-1.0),
        1.0,
        (0.1, 0.1, 0.2),
        ((0.5, 0, 0), flat),
        {"O": ((0, 0, 0), flat, None)},
        rates,
    )
    drawing.joint("RevoluteJoint", "J", "O", "Arm/O")
    return drawing


def test_without_a_motor_the_rates_of_the_file_are_the_start():
    r = mechanism(pendulum(((0, 0, 0), (0, 0, 1.5)))).simulate(0.01)
    assert r["Arm.omega"][0] == pytest.approx(1.5, rel=1e-12)
    assert "out of the plane" in " ".join(imported(pendulum(((0, 0, 0), (0.4, 0, 1.5)))).left_out)


def test_gravity_along_the_axes_is_told_and_the_rest_is_taken():
    drawing = pendulum()
    drawing.gravity = (1.0, -2.0, -9.81)
    read = imported(drawing)
    assert read.document["gravity"] == [1.0, -2.0]
    assert any("gravity" in word and "-9.81" in word for word in read.left_out)


def test_forces_and_limits_are_left_out_by_name():
    drawing = foreign.fourbar()
    drawing.forces = ["\t\tForceTorqueGeneral", "\t\t\tName", "\t\t\t\tGust"]
    drawing.sets = ["\t\tLimits", "\t\t\tRotationLimit", "\t\t\t\tName", "\t\t\t\t\tEnd stop"]
    read = imported(drawing)
    assert {"force Gust", "limit End stop"} <= set(read.left_out)
    assert max(errors(rt.loads(text_of(read)))) < 1e-9


def test_a_run_that_begins_later_keeps_the_time_of_the_file():
    drawing = foreign.fourbar()
    drawing.times = ("0.25", "1.25", "0.01")
    r = mechanism(drawing).inverse_dynamics([0.15, 0.5])
    want = [foreign.STORED[0.4][0], foreign.STORED[0.75][0]]
    np.testing.assert_allclose(np.abs(r["Motion1.torque"]), np.abs(want), rtol=1e-9)


def test_a_motor_between_markers_turns_the_joint_between_their_parts():
    drawing = foreign.fourbar()
    drawing.ground["Stand"] = ((0.5, 0.5, 0), about_z(0.3), None)
    markers = drawing.parts["Part1"][5]
    markers["Needle"] = ((0.3, 0.1, 0), about_z(0.3), None)
    lines = ["\tName", "\t\tMotion1", "\tMarkerI", "\t\t/Assembly1/{}", "\tMarkerJ", "\t\t/Assembly1/{}"]
    lines += ["\tMotionJoint", "\t\t", "\tRotationZ", "\t\t{}2*pi*time"]
    for i, j, sign in (("Stand", "Part1/Needle", ""), ("Part1/Needle", "Stand", "-")):
        drawing.motions = [["RotationalMotion", *"\n".join(lines).format(i, j, sign).split("\n")]]
        assert max(errors(mechanism(drawing))) < 1e-9


def test_a_unit_of_length_scales_everything_that_has_one():
    plain, scaled = mechanism(foreign.fourbar()), mechanism(foreign.fourbar(), scale=1e-3)
    a, b = (m.inverse_dynamics([0.1, 0.4]) for m in (plain, scaled))
    np.testing.assert_allclose(b["Motion1.torque"], 1e-6 * a["Motion1.torque"], rtol=1e-10)  # kg m^2/s^2
    np.testing.assert_allclose(b["Joint2.fx"], 1e-3 * a["Joint2.fx"], rtol=1e-10)


def test_names_become_names_of_a_model():
    drawing = foreign.fourbar()
    for part, word in (("Part1", "in"), ("Part2", "Doc#Box 1")):
        drawing.parts[word] = drawing.parts.pop(part)
        drawing.joints = [
            (kind, name, *(end.replace(f"{part}/", f"{word}/") for end in (i, j)), more)
            for kind, name, i, j, more in drawing.joints
        ]
    read = imported(drawing)
    assert {"in_", "Doc_Box_1"} < set(read.document["bodies"])
    assert any("Doc#Box 1 is Doc_Box_1" in word for word in read.taken)
    assert max(errors(rt.loads(text_of(read)))) < 1e-9


# ---------------------------------------------------------------- what is refused
def refusal(text: str) -> str:
    with pytest.raises(rt.ModelError) as caught:
        read_asmt(text, "f.asmt", Assumptions())
    words = str(caught.value)
    assert re.fullmatch(r"f\.asmt(:\d+)?: [^\n]+", words), words
    return words


def test_what_is_not_planar_is_refused_by_the_name_of_the_joint():
    drawing = foreign.fourbar()
    drawing.ground["Marker1"] = (*drawing.ground["Marker1"][:1], rotation((1, 0, 0), 2e-6), None)
    words = refusal(drawing.text())
    assert re.search("Joint4.*Marker1.*planar", words), words
    drawing.ground["Marker1"] = (*drawing.ground["Marker1"][:1], rotation((1, 0, 0), 5e-7), None)
    assert imported(drawing).document["joints"]


def test_a_slider_that_leaves_the_plane_is_refused():
    drawing = slider_crank("TranslationalJoint")
    drawing.ground["Line"] = ((0.3, 0, 0), rotation((0, 1, 0), math.pi / 2 + 0.01), None)
    assert "J4" in refusal(drawing.text())


@pytest.mark.parametrize(("change", "names"), [
    (("RevoluteJoint", "SphericalJoint"), ("Joint1", "SphericalJoint")),
    (("/Assembly1/Part2/Marker1", "/Assembly1/Part2/Marker7"), ("Joint2", "Marker7")),
    (("/Assembly1/Joint1", "/Assembly1/Joint9"), ("Motion1", "Joint9")),
    (("2.0d*pi*time", "2.0d*pi*tme"), ("Motion1", "tme")),
    (("2.0d*pi*time", "spline(time, 1)"), ("Motion1", "spline")),
    (("2.0d*pi*time", "1/(time*0)"), ("Motion1",)),
    (("RotationalMotion", "GeneralMotion"), ("Motion1", "GeneralMotion")),
    (("\t\t\t\tMass\n\t\t\t\t\t0.4", "\t\t\t\tMass\n\t\t\t\t\tnan"), ("Part2", "nan")),
    (("\t\t\t\tMass\n\t\t\t\t\t0.4", "\t\t\t\tMass\n\t\t\t\t\t-0.4"), ("Part2", "negative")),
    (("\t\t\t\tMass\n\t\t\t\t\t0.4", "\t\t\t\tMass\n\t\t\t\t\t1e400"), ("Part2",)),
    (("GeneralConstraintSets", "GeneralConstraintSets\n\t\t\tMystery"), ("Mystery",)),
    (("\tConstantGravity", "\tGravity"), ("ConstantGravity",)),
])  # fmt: skip
def test_what_cannot_be_read_is_refused_by_name(change, names):
    text = foreign.fourbar().text()
    assert change[0] in text
    words = refusal(text.replace(*change))
    assert all(name in words for name in names), words


def test_a_matrix_that_is_no_rotation_is_refused():
    drawing = foreign.fourbar()
    drawing.parts["Part2"] = (drawing.parts["Part2"][0], np.diag([1, 1, -1.0]), *drawing.parts["Part2"][2:])
    assert "Part2" in refusal(drawing.text())


def test_a_file_that_is_cut_off_is_refused_up_to_its_last_value():
    text = foreign.fourbar().text()
    end = text.index("hout")  # what is needed ends with the interval of output
    for at in range(40, end, 97):
        refusal(text[:at])
    assert read_asmt(text[: text.rindex("0.01") + 4], "f.asmt", Assumptions()).document["joints"]


# ---------------------------------------------------------------- functions of time
@pytest.mark.parametrize(("text", "want"), [
    ("2.0d*pi*time", 0.6 * math.pi), ("-2^2", -4), ("2*-3^2", 18), ("2^3^2", 512), ("8/2/2", 2), ("1 - 2 - 3", -4),
    ("(45.0d + 45.0d*sin((360.0d*time - 90.0d)*pi/180.0d))*pi/180.0d", math.pi / 4 * (1 + math.sin(math.pi / 10))),
    ("1.5d2*time", 45), ("1e3*.5", 500), ("arctan(1000*(time - (-2)))", math.atan(2300)), ('"note" 2*<n>time', 0.6),
    ("2.", 2), ("abs(-time)^2", 0.09), ("+time - -1", 1.3),
])  # fmt: skip
def test_functions_of_time_mean_here_what_they_mean_there(text, want):
    expression = parse(model_expression(text, 0.0))
    assert value(replaced(expression, {"t": Number(0.3, 0)}), {}) == pytest.approx(want, rel=1e-14)
    later = parse(model_expression(text, 0.1))
    assert value(replaced(later, {"t": Number(0.2, 0)}), {}) == pytest.approx(want, rel=1e-13)


@pytest.mark.parametrize(
    "text", ["", "2*", "(1", "1)", "sin 2", "foo(2)", "1 2", "(" * 999 + "1", "^" * 99, "2..3", "²", "__import__('os')"]
)
def test_other_texts_are_no_functions_of_time(text):
    with pytest.raises(MotionTextError):
        model_expression(text, 0.0)


def test_the_text_is_in_the_order_of_a_model_file_and_keeps_every_digit():
    text = text_of(imported(foreign.fourbar()))
    places = [
        text.index(word)
        for word in (
            "# from",
            "format",
            "gravity",
            "[ground",
            "[bodies",
            "[joints",
            "[drivers",
            "[initial",
            "[simulate",
        )
    ]
    assert all(a < b for a, b in pairwise(places))
    table = tomllib.loads(text)
    assert table["bodies"]["Part2"]["inertia"] == 0.13466666666667
    assert table["initial"]["Part3"]["angle"] == pytest.approx(-1.6060600451779, abs=1e-15)
