"""Bodies at rest on surfaces: equilibria, small motions about them, what is said of corners past an end."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.language.materials import contact_modulus

G = 9.81
WORLD = f"format = 1\ngravity = [0, -{G}]\nground.points = {{ O = [0, 0] }}\n"
SMOOTH = '{ model = "impact" }'
ROUGH = '{ model = "impact", friction = 0.5 }'


def body(name, points, mass, inertia, place):
    named = ", ".join(f"{key} = [{x!r}, {y!r}]" for key, (x, y) in points.items())
    at = ", ".join(f"{key} = {value!r}" for key, value in zip(("x", "y", "angle"), place, strict=True))
    return (
        f"bodies.{name} = {{ points = {{ {named} }}, center = [0, 0], mass = {mass}, inertia = {inertia} }}\n"
        f"initial.{name} = {{ {at} }}\n"
    )


def surface(name, b, contact, more):
    return f'joints.{name} = {{ type = "surface", connect = ["ground.O", "{b}"], contact = {contact}, {more} }}\n'


def cup(contact):
    disc = body("disc", {"C": (0, 0)}, 2.0, 0.01, (0.1, -0.38, 0.0))
    return rt.loads(WORLD + disc + surface("cup", "disc.C", contact, "radius = 0.5, hollow = true, roller = 0.1"))


def plank(contact):
    polygon = "polygon = [[-0.5, -0.05], [0.5, -0.05], [0.5, 0.05], [-0.5, 0.05]]"
    text = (
        f"bodies.plank = {{ {polygon}, mass = 2, points = {{ A = [0, 0] }} }}\ninitial.plank = {{ x = 0, y = 0.36 }}\n"
    )
    return rt.loads(WORLD + text + surface("drum", "plank.A", contact, "radius = 0.3, outline = true"))


def test_a_disc_in_a_smooth_cup_swings_as_a_pendulum_and_a_rough_one_rolls():
    smooth, rough = cup(SMOOTH).modes(), cup(ROUGH).modes()
    assert smooth.omega[-1] == pytest.approx(math.sqrt(G / 0.4), rel=1e-9)
    assert rough.omega == pytest.approx([math.sqrt(2 * G / (3 * 0.4))], rel=1e-9)


def test_a_plank_rocks_on_a_rough_drum_and_slides_off_a_smooth_one():
    """w^2 = m g (R - h)/(I + m h^2)."""
    rough, smooth = plank(ROUGH).modes(), plank(SMOOTH).equilibrium()[0]
    inertia = 2 * (1 + 4 * 0.05**2) / 12
    assert rough.omega == pytest.approx([math.sqrt(2 * G * 0.25 / (inertia + 2 * 0.05**2))], rel=1e-8)
    assert not smooth.stable
    assert smooth["drum.normal"] == pytest.approx(2 * G, rel=1e-9)


def test_a_load_beside_the_middle_of_a_block_is_shared_by_its_corners():
    block = body("block", {"P": (-0.1, -0.2), "Q": (0.1, -0.2), "R": (0.06, 0.2)}, 5.0, 0.1, (0, 0.3, 0.02))
    load = 'loads.F = { type = "force", at = "block.R", force = [0, -30] }\n'
    m = rt.loads(WORLD + block + surface("floor", "block.P", SMOOTH, 'axis = "0 deg", corners = ["P", "Q"]') + load)
    rest = next(rest for rest in m.equilibrium() if abs(rest["block.angle"]) < 1e-6)
    on_q = 2.5 * G + 30 * (0.1 + 0.06) / 0.2
    assert rest["floor.Q.normal"] == pytest.approx(on_q, rel=1e-9)
    assert rest["floor.P.normal"] == pytest.approx(5 * G + 30 - on_q, rel=1e-9)
    assert rest["block.y"] == pytest.approx(0.2, abs=1e-12)


def test_a_disc_in_a_groove_presses_on_both_of_its_sides():
    disc = body("disc", {"C": (0, 0)}, 1.0, 0.01, (0.02, 0.2, 0.0))
    sides = surface("left", "disc.C", SMOOTH, 'axis = "-40 deg", roller = 0.05')
    sides += surface("right", "disc.C", SMOOTH, 'axis = "25 deg", roller = 0.05')
    rest = rt.loads(WORLD + disc + sides).equilibrium()[0]
    steep, gentle = math.radians(40), math.radians(25)
    normals = np.linalg.solve([[math.sin(steep), -math.sin(gentle)], [math.cos(steep), math.cos(gentle)]], [0, G])
    assert [rest["left.normal"], rest["right.normal"]] == pytest.approx(normals, rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_a_polygon_stands_on_those_of_its_edges_over_which_its_mass_centre_is(seed):
    rng = np.random.default_rng(seed)
    turns = np.sort(rng.uniform(0, 0.9, 5)) + 2 * math.pi / 5 * np.arange(5)
    corners = {f"C{k}": (0.1 * math.cos(turn), 0.1 * math.sin(turn)) for k, turn in enumerate(turns)}
    shift = rng.uniform(-0.03, 0.03, 2)
    corners = {key: (float(x - shift[0]), float(y - shift[1])) for key, (x, y) in corners.items()}
    places = np.array(list(corners.values()))
    stands = []
    for k in range(5):
        first, edge = places[k], places[(k + 1) % 5] - places[k]
        if 0 < -first @ edge < edge @ edge:
            stands.append(-math.atan2(edge[1], edge[0]) % (2 * math.pi))
    names = ", ".join(f'"{key}"' for key in corners)
    text = body("b", corners, 1.0, 0.005, (0, 0.2, float(rng.uniform(0, 6))))
    m = rt.loads(WORLD + text + surface("floor", "b.C0", SMOOTH, f'axis = "0 deg", corners = [{names}]'))
    found = [rest["b.angle"] % (2 * math.pi) for rest in m.equilibrium(effort=4) if not rest.falling]
    assert all(min(abs(math.remainder(angle - one, 2 * math.pi)) for one in stands) < 1e-6 for angle in found)
    assert len({round(angle, 6) for angle in found}) == len(stands)


def test_a_disc_of_steel_is_as_stiff_as_two_spheres_of_its_radii():
    steel = '{ model = "hertz", bush_material = "steel", pin_material = "steel" }'
    disc = body("disc", {"C": (0, 0)}, 1.0, 0.01, (0, 0.2, 0.0))
    for more, curvature in (
        ('axis = "0 deg", ', 10.0),
        ("radius = 0.4, ", 12.5),
        ("radius = 0.4, hollow = true, ", 7.5),
    ):
        joint = rt.loads(WORLD + disc + surface("on", "disc.C", steel, f"{more}roller = 0.1")).model.joints["on"]
        stiffness = joint.contact.static.values["stiffness"]
        assert stiffness == pytest.approx(4 / 3 * contact_modulus("steel", "steel") / math.sqrt(curvature), rel=1e-12)
    with pytest.raises(rt.ModelError, match="touches in a point"):
        rt.loads(
            WORLD
            + disc
            + surface("on", "disc.C", steel[:-1] + ', geometry = "johnson" }', 'axis = "0 deg", roller = 0.1')
        )


def test_ideal_mechanisms_keep_their_surfaces():
    assert cup(SMOOTH).ideal().model.joints["cup"].contact.rigid


def test_a_run_says_where_a_corner_has_left_the_end_of_its_segment():
    block = body("block", {"P": (-0.1, -0.05), "Q": (0.1, -0.05)}, 1.0, 0.01, (0.1, 0.06, 0.0))
    table = surface("table", "block.P", SMOOTH, 'axis = "0 deg", length = "0.25 m", corners = ["P", "Q"]')
    said = str(rt.loads(WORLD + block + table).simulate(0.2, method="event").trust)
    assert "table: a corner has left the end of its segment" in said
