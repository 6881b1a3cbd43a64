"""Loops close in the way in which given values survive, or change least: random mechanisms, closed in closed form."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import rattle as rt

Angles = dict[str, float]


def along(angle: float, length: float = 1.0) -> np.ndarray:
    """The vector (2,) of this direction [rad] and length."""
    return length * np.array([math.cos(angle), math.sin(angle)])


def direction(vector: np.ndarray) -> float:
    """Direction of a vector (2,) [rad]."""
    return math.atan2(vector[1], vector[0])


def apart(one: float, other: float) -> float:
    """How far two angles are apart [rad], whole turns left out."""
    return abs(math.remainder(one - other, math.tau))


def dyad(first: np.ndarray, last: np.ndarray, long: float, wide: float) -> list[tuple[float, float]]:
    """Both pairs of angles of two bars, one pinned at each of two points, whose other ends meet; [] near a line."""
    between = last - first
    reach = float(np.hypot(*between))
    if not 1.1 * abs(long - wide) + 0.05 < reach < 0.95 * (long + wide):
        return []
    bend = math.acos((long**2 + reach**2 - wide**2) / (2 * long * reach))
    pairs = []
    for sign in (1, -1):
        angle = direction(between) + sign * bend
        pairs.append((angle, direction(first + along(angle, long) - last)))
    return pairs


def fourbars(count: int, seed: int) -> Iterator[tuple[np.ndarray, list[Angles], np.random.Generator]]:
    """Lengths (4,) of ground, crank, coupler, rocker, and the angles of both closings, in random order."""
    rng, made = np.random.default_rng(seed), 0
    while made < count:
        sizes, crank = rng.uniform(0.5, 3.0, 4), rng.uniform(-math.pi, math.pi)
        pairs = dyad(along(crank, sizes[1]), np.array([sizes[0], 0.0]), sizes[2], sizes[3])
        if not pairs or apart(pairs[0][0], pairs[1][0]) < 0.3:
            continue
        ways = [dict(zip(("crank", "coupler", "rocker"), (crank, *pair), strict=True)) for pair in pairs]
        made += 1
        yield sizes, ways[:: rng.choice([1, -1])], rng


def fourbar(sizes: np.ndarray, drive: float | None, given: Angles, masses: np.ndarray) -> rt.Mechanism:
    d, a, b, c = map(float, sizes)
    m = rt.Mechanism("four-bar").ground(A=[0, 0], D=[d, 0])
    m.bar("crank", "A", "B", length=a, mass=masses[0]).bar("coupler", "B", "C", length=b, mass=masses[1])
    m.bar("rocker", "D", "C", length=c, mass=masses[2])
    m.revolute("A", "ground.A", "crank.A").revolute("B", "crank.B", "coupler.B")
    m.revolute("C", "coupler.C", "rocker.C").revolute("D", "ground.D", "rocker.D")
    if drive is not None:
        m.driver("motor", "A", angle=f"{drive!r} + t")
    for body, angle in given.items():
        m.initial(body, angle=angle)
    return m


def angles_of(m: rt.Mechanism) -> Angles:
    return dict(zip(m.system.bodies, m.start.q[2::3].tolist(), strict=True))


WAYS = (
    "driver coupler", "driver rocker", "crank coupler", "crank rocker", "coupler", "rocker", "crank coupler rocker",
)  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_angles_of_a_fourbar_that_fit_together_are_kept(way):
    for sizes, (right, _), rng in fourbars(100, seed=1):
        given = {body: right[body] for body in way.split() if body != "driver"}
        m = fourbar(sizes, right["crank"] if "driver" in way else None, given, rng.uniform(0.2, 5.0, 3))
        q = angles_of(m)
        assert max(apart(q[body], angle) for body, angle in given.items()) < 1e-9
        assert not m.start.notes
        if len(given) > 1 or "driver" in way:
            assert max(apart(q[body], angle) for body, angle in right.items()) < 1e-7


@pytest.mark.parametrize("off", [10.0, 30.0])
@pytest.mark.parametrize("body", ["coupler", "rocker"])
def test_a_rough_angle_of_a_driven_fourbar_takes_the_nearer_of_its_closings(body, off):
    for sizes, ways, rng in fourbars(75, seed=2):
        asked = ways[0][body] + rng.choice([-1, 1]) * math.radians(off)
        near, far = sorted(ways, key=lambda way: apart(way[body], asked))
        if apart(far[body], asked) - apart(near[body], asked) < 1e-3:
            continue
        q = angles_of(fourbar(sizes, ways[0]["crank"], {body: asked}, rng.uniform(0.2, 5.0, 3)))
        assert apart(q[body], near[body]) < 1e-9


@pytest.mark.parametrize("way", ["crank coupler", "crank rocker", "crank coupler rocker"])
def test_rough_angles_of_a_free_fourbar_change_least_of_all_positions_by_inertia(way):
    turns = np.linspace(-math.pi, math.pi, 20_001)
    for sizes, (right, _), rng in fourbars(8, seed=3):
        d, a, b, c = sizes
        masses = rng.uniform(0.2, 5.0, 3)
        inertia = dict(zip(right, masses * sizes[1:] ** 2 / 12, strict=True))
        asked = {body: right[body] + rng.choice([-1, 1]) * math.radians(10) for body in way.split()}
        x, y = d - a * np.cos(turns), -a * np.sin(turns)
        reach = np.hypot(x, y)
        with np.errstate(invalid="ignore"):
            bend = np.arccos((b**2 + reach**2 - c**2) / (2 * b * reach))  # nan where the bars do not reach

        def change(every: Any, asked: Angles = asked, inertia: Angles = inertia) -> Any:
            return sum(
                w * ((every[k] - asked[k] + math.pi) % math.tau - math.pi) ** 2
                for k, w in inertia.items()
                if k in asked
            )

        least = math.inf
        for sign in (1, -1):
            coupler = np.arctan2(y, x) + sign * bend
            rocker = np.arctan2(b * np.sin(coupler) - y, b * np.cos(coupler) - x)
            least = min(least, np.nanmin(change({"crank": turns, "coupler": coupler, "rocker": rocker})))
        assert change(angles_of(fourbar(sizes, None, asked, masses))) < 1.01 * least + 1e-7


@pytest.mark.parametrize(
    ("sizes", "masses", "asked", "bend"),
    [
        ([1.882, 0.623, 2.869, 1.845], [1.01, 3.69, 2.52], {"crank": -1.9621, "coupler": 0.4761}, 1),
        ([2.12, 0.544, 2.661, 1.753], [0.8, 4.81, 3.35], {"crank": 2.4764, "coupler": -0.2827}, -1),
    ],
)
def test_rough_angles_of_a_free_fourbar_take_the_nearer_branch_whatever_the_masses(sizes, masses, asked, bend):
    """On the other branch they change three times as much; bend: side of the line to D where the coupler is."""
    q = angles_of(fourbar(np.array(sizes), None, asked, np.array(masses)))
    line = direction(np.array([sizes[0], 0.0]) - along(q["crank"], sizes[1]))
    assert math.copysign(1.0, math.sin(q["coupler"] - line)) == bend


# ---------------------------------------------------------------- other loops
def kept(m: rt.Mechanism, given: dict[str, dict[str, float]]) -> bool:
    """True if the start has all given values, angles but for whole turns, and says nothing of them."""
    for body, values in given.items():
        m.initial(body, **values)
    bodies = m.system.bodies
    missed = []
    for body, values in given.items():
        x, y, angle = m.start.q[3 * bodies.index(body) :][:3]
        now = {"x": x, "y": y, "angle": angle}
        missed += [apart(now[key], value) if key == "angle" else abs(now[key] - value) for key, value in values.items()]
    return max(missed) < 1e-9 and not m.start.notes


def test_values_of_a_slider_crank_that_fit_together_are_kept():
    rng = np.random.default_rng(4)
    for _ in range(40):
        a, length, offset, axis = rng.uniform(0.2, 1), rng.uniform(1.4, 3), rng.uniform(-0.15, 0.15), rng.uniform(-3, 3)
        crank, side = rng.uniform(-3, 3), rng.choice([-1, 1])
        pin = along(crank, a)
        beside = offset - pin @ along(axis + math.pi / 2)
        end = (pin @ along(axis) + side * math.sqrt(length**2 - beside**2)) * along(axis) + offset * along(
            axis + math.pi / 2
        )
        masses = rng.uniform(0.2, 5.0, 3)
        middle, rod, (x, y) = (pin + end) / 2, direction(end - pin), end.tolist()

        def made(
            driven: bool, a=a, length=length, offset=offset, axis=axis, crank=crank, masses=masses
        ) -> rt.Mechanism:
            m = rt.Mechanism("slider-crank").ground(O=[0, 0], G=along(axis + math.pi / 2, offset).tolist())
            m.bar("crank", "O", "A", length=a, mass=masses[0]).bar("rod", "A", "B", length=length, mass=masses[1])
            m.body("slider", points={"B": [0, 0]}, mass=masses[2], inertia=0.01)
            m.revolute("O", "ground.O", "crank.O").revolute("A", "crank.A", "rod.A").revolute("B", "rod.B", "slider.B")
            m.prismatic("guide", "ground.G", "slider.B", axis=axis)
            return m.driver("motor", "O", angle=f"{crank!r} + 3*t") if driven else m

        assert kept(made(True), {"slider": {"x": x}})
        assert kept(made(True), {"slider": {"x": x, "y": y}})
        assert kept(made(True), {"rod": {"angle": rod}})
        assert kept(made(True), {"rod": {"x": middle[0], "y": middle[1]}})
        assert kept(made(False), {"crank": {"angle": crank}, "slider": {"x": x}})
        assert kept(made(False), {"crank": {"angle": crank}, "rod": {"angle": rod}})
        assert kept(made(False), {"rod": {"angle": rod}, "slider": {"x": x}})
        assert kept(made(False), {"slider": {"x": x}})


def test_values_of_a_crank_in_a_slot_that_fit_together_are_kept():
    rng = np.random.default_rng(5)
    for _ in range(15):
        base, crank, line, beside = rng.uniform(1.5, 3), rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(0, 0.2)
        a = rng.uniform(0.3, 1.2)
        arm = along(crank, a) - np.array([base, 0.0])
        slid = rng.choice([-1, 1]) * math.sqrt(arm @ arm - beside**2)
        start = along(line + math.pi / 2, beside)
        rocker = direction(arm) - direction(start + along(line, slid))
        for driven in (True, False):
            m = rt.Mechanism("crank in a slot").ground(O=[0, 0], D=[base, 0]).bar("crank", "O", "A", length=a, mass=1)
            m.body("rocker", points={"D": [0, 0], "S": start.tolist()}, center=[0.2, 0.1], mass=2, inertia=0.5)
            m.revolute("O", "ground.O", "crank.O").revolute("D", "ground.D", "rocker.D")
            m.joint("slot", "slot", "rocker.S", "crank.A", axis=line)
            if driven:
                m.driver("motor", "O", angle=f"{crank!r} + 3*t")
            own: dict[str, Any] = {} if driven else {"crank": {"angle": crank}}
            assert kept(m, {**own, "rocker": {"angle": rocker}})


SIX = (
    "crank: coupler fifth", "crank: rocker sixth", ": crank coupler fifth", ": sixth coupler", ": coupler fifth",
    "sixth: fifth coupler", "sixth: coupler", "sixth: crank coupler",
)  # fmt: skip


@pytest.mark.parametrize("way", SIX)
def test_angles_of_a_sixbar_that_fit_together_are_kept(way):
    driven, _, names = way.partition(": ") if not way.startswith(":") else ("", "", way[2:])
    tried = 0
    for sizes, (angles, _), rng in fourbars(20, seed=6):
        crank, coupler = angles["crank"], angles["coupler"]
        pin = along(crank, sizes[1])
        arm = along(coupler + rng.uniform(-1, 1), rng.uniform(0.2, 0.8) * sizes[2])
        base = rng.uniform(-2, 4, 2)
        reach = float(np.hypot(*(base - pin - arm)))
        fifth, sixth = rng.uniform(0.4, 2.0, 2) * reach
        pairs = dyad(pin + arm, base, fifth, sixth)
        if not pairs:
            continue
        every = {**angles, **dict(zip(("fifth", "sixth"), pairs[rng.integers(2)], strict=True))}
        point = along(direction(arm) - coupler, float(np.hypot(*arm)))
        m = rt.Mechanism("six-bar").ground(A=[0, 0], D=[float(sizes[0]), 0], E=base.tolist())
        m.bar("crank", "A", "B", length=float(sizes[1]), mass=1).bar("rocker", "D", "C", length=float(sizes[3]), mass=1)
        points = {"B": [0, 0], "C": [float(sizes[2]), 0], "P": point.tolist()}
        m.body("coupler", points=points, center=[0.3, 0.1], mass=1, inertia=0.2)
        m.bar("fifth", "P", "Q", length=fifth, mass=1).bar("sixth", "E", "Q", length=sixth, mass=2)
        m.revolute("A", "ground.A", "crank.A").revolute("B", "crank.B", "coupler.B").revolute(
            "C", "coupler.C", "rocker.C"
        )
        m.revolute("D", "ground.D", "rocker.D").revolute("P", "coupler.P", "fifth.P").revolute(
            "Q", "fifth.Q", "sixth.Q"
        )
        m.revolute("E", "ground.E", "sixth.E")
        if driven:
            m.driver("motor", {"crank": "A", "sixth": "E"}[driven], angle=f"{every[driven]!r} + 3*t")
        assert kept(m, {body: {"angle": every[body]} for body in names.split()})
        tried += 1
    assert tried >= 5


@pytest.mark.parametrize(
    "way", ["two: left", "two: right", "one: left far", "one: left right", ": near far left", ": left"]
)
def test_angles_of_a_fivebar_that_fit_together_are_kept(way):
    drivers, _, names = way.partition(": ") if not way.startswith(":") else ("", "", way[2:])
    rng = np.random.default_rng(7)
    for _ in range(15):
        base, turns = rng.uniform(1, 3), rng.uniform(-3, 3, 2).tolist()
        arms = rng.uniform(0.5, 1.5, 2).tolist()
        first, last = along(turns[0], arms[0]), np.array([base, 0.0]) + along(turns[1], arms[1])
        bars = (rng.uniform(0.55, 2.0, 2) * np.hypot(*(last - first))).tolist()
        pairs = dyad(first, last, *bars)
        if not pairs:
            continue
        every = dict(zip(("near", "far", "left", "right"), (*turns, *pairs[rng.integers(2)]), strict=True))
        m = rt.Mechanism("five-bar").ground(O=[0, 0], D=[float(base), 0])
        m.bar("near", "O", "A", length=arms[0], mass=1).bar("far", "D", "B", length=arms[1], mass=2)
        m.bar("left", "A", "P", length=bars[0], mass=3).bar("right", "B", "P", length=bars[1], mass=1)
        m.revolute("O", "ground.O", "near.O").revolute("A", "near.A", "left.A").revolute("P", "left.P", "right.P")
        m.revolute("D", "ground.D", "far.D").revolute("B", "far.B", "right.B")
        if drivers:
            m.driver("first", "O", angle=f"{turns[0]!r} + t")
        if drivers == "two":
            m.driver("second", "D", angle=f"{turns[1]!r} + t")
        assert kept(m, {body: {"angle": every[body]} for body in names.split()})


def fourbars_in_a_row(count: int, seed: int) -> tuple[rt.Mechanism, float]:
    """Every rocker moves the next coupler; and the angle of the last of them [rad]."""
    rng = np.random.default_rng(seed)
    m = rt.Mechanism("row").ground(O=[0, 0]).bar("rocker0", "O", "E", length=0.5, mass=1)
    m.revolute("O", "ground.O", "rocker0.O").driver("motor", "O", angle="0.4 + t")
    pin, angle = along(0.4, 0.5), 0.4
    for n in range(1, count + 1):
        pivot, angle = np.array([2.0 * n, 0.0]), float(rng.uniform(-3.0, 3.0))
        joint = pivot + along(angle, 0.9)
        m.ground(**{f"D{n}": pivot.tolist()})
        m.bar(f"coupler{n}", "B", "C", length=float(np.hypot(*(joint - pin))), mass=1)
        m.body(f"rocker{n}", points={"D": [0, 0], "C": [0.9, 0], "E": [0.5, 0.2]}, mass=1, inertia=0.1)
        m.revolute(f"B{n}", f"rocker{n - 1}.E", f"coupler{n}.B").revolute(f"C{n}", f"coupler{n}.C", f"rocker{n}.C")
        m.revolute(f"D{n}", f"ground.D{n}", f"rocker{n}.D")
        pin = pivot + along(angle, 0.5) + along(angle + math.pi / 2, 0.2)
    return m, angle


@pytest.mark.parametrize("seed", [2, 3])
def test_a_value_at_the_end_of_a_long_row_of_fourbars_is_kept(seed):
    m, last = fourbars_in_a_row(10, seed)
    assert kept(m, {"rocker10": {"angle": last}})


def test_angles_of_more_loops_than_dense_matrices_are_made_for_are_kept():
    """Seventy couplers and rockers side by side: 423 rows; every second coupler on either branch."""
    m = rt.Mechanism("fan").ground(O=[0, 0], D=[3.0, 0.0]).bar("crank", "O", "E", length=1.0, mass=1)
    m.revolute("O", "ground.O", "crank.O").driver("motor", "O", angle="0.5 + t")
    given, fits = {}, {}
    for n in range(70):
        coupler, rocker = dyad(along(0.5), np.array([3.0, 0.0]), 1.6 + 0.01 * n, 1.5)[n % 2]
        m.bar(f"c{n}", "E", "C", length=1.6 + 0.01 * n, mass=1).bar(f"r{n}", "D", "C", length=1.5, mass=1)
        m.revolute(f"E{n}", "crank.E", f"c{n}.E").revolute(f"C{n}", f"c{n}.C", f"r{n}.C")
        m.revolute(f"D{n}", "ground.D", f"r{n}.D")
        given[f"c{n}"], fits[f"r{n}"] = {"angle": coupler}, rocker
    assert kept(m, given)
    q = angles_of(m)
    assert max(apart(q[body], angle) for body, angle in fits.items()) < 1e-9


@pytest.mark.parametrize("between", ["rod", "cylinder"])
def test_values_of_a_mechanism_on_a_floating_base_that_fit_together_are_kept(between):
    """No joint leads from the ground to the base: it stands where it is given."""
    place, crank, lever = np.array([2.0, 0.3]), math.radians(65), math.radians(95)
    m = rt.Mechanism("floating").ground(G=[0, 0]).body("base", points={"A": [0, 0], "D": [1, 0]}, mass=5, inertia=1)
    m.bar("crank", "A", "B", length=0.3, mass=1).bar("lever", "D", "C", length=0.6, mass=1)
    m.revolute("A", "base.A", "crank.A").revolute("D", "base.D", "lever.D")
    pins = along(crank, 0.3), np.array([1.0, 0.0]) + along(lever, 0.6)
    given = {"base": {"x": 2.0, "y": 0.3, "angle": 0.0}, "crank": {"angle": crank}, "lever": {"angle": lever}}
    if between == "rod":
        m.rod("rod", "crank.B", "lever.C", length=float(np.hypot(*(pins[0] - pins[1]))))
    else:
        arm = direction(pins[1] - pins[0])
        m.body("barrel", points={"P": [0, 0]}, mass=1, inertia=0.1).revolute("B", "crank.B", "barrel.P")
        m.body("piston", points={"Q": [0, 0]}, mass=1, inertia=0.1).revolute("C", "lever.C", "piston.Q")
        m.prismatic("P", "barrel.P", "piston.Q")
        given["barrel"] = {"angle": arm}
    m.load("spring", type="spring", connect=["ground.G", "base.A"], stiffness=100, free_length=0)
    assert kept(m, given)
    assert m.start.q[:2] == pytest.approx(place, abs=1e-9)


@pytest.mark.parametrize("turns", [0, -1, 2])
@pytest.mark.parametrize("driven", [False, True])
def test_angles_of_bodies_that_turn_together_may_be_given_in_different_turns(turns, driven):
    """A boom on a cylinder: the first of them counts, and a driver before all."""
    m = rt.Mechanism("cylinder").ground(O=[0, 0], C=[1, 0]).bar("boom", "O", "A", length=1, mass=5)
    m.body("barrel", points={"C": [0, 0]}, center=[0.3, 0], mass=2, inertia=0.1)
    m.body("piston", points={"A": [0, 0]}, center=[-0.3, 0], mass=1, inertia=0.1)
    m.revolute("O", "ground.O", "boom.O").revolute("C", "ground.C", "barrel.C").revolute("A", "boom.A", "piston.A")
    m.prismatic("P", "barrel.C", "piston.A")
    if driven:
        m.driver("motor", "O", angle="90 deg + t")
    given = {"boom": 90.0 + 360 * turns * driven, "barrel": 135.0, "piston": 135.0 + 360 * turns}
    for body, angle in given.items():
        m.initial(body, angle=math.radians(angle))
    assert np.degrees(list(angles_of(m).values())) == pytest.approx([90, 135, 135], abs=1e-9)
    assert bool(m.start.notes) == bool(turns)


def test_slopes_are_those_of_the_closing_that_was_asked_for():
    """Independent reference: the triangle of coupler and rocker, differenced."""
    sizes, crank = np.array([4.0, 1.0, 2.99, 2.1]), math.radians(30)

    def coupler(length: float) -> float:
        pin = along(crank, sizes[1])
        between = np.array([sizes[0], 0.0]) - pin
        reach = float(np.hypot(*between))
        return direction(between) + math.acos((length**2 + reach**2 - sizes[3] ** 2) / (2 * length * reach))

    m = fourbar(sizes, crank, {"coupler": coupler(2.99)}, np.ones(3)).parameter("b", 2.99, tol=0.05)
    m = m.set({"bodies.coupler.length": "b"})
    low, high = m.many({"b": [2.99 - 1e-4, 2.99 + 1e-4]}, ["at(coupler.angle, 0)"], 0.01)["at(coupler.angle, 0)"]
    assert (low + high) / 2 == pytest.approx(coupler(2.99), abs=1e-6)
    assert (high - low) / 2e-4 == pytest.approx((coupler(2.99 + 1e-4) - coupler(2.99 - 1e-4)) / 2e-4, rel=1e-5)


# ---------------------------------------------------------------- many
@pytest.mark.parametrize(
    ("drive", "given"),
    [(0.5236, {}), (0.5236, {"coupler": 0.4}), (None, {"coupler": 0.5}), (None, {"crank": 0.5236, "coupler": 0.4993})],
)
def test_samples_of_a_length_start_as_each_of_them_alone(drive, given):
    """Among them some that cannot be put together."""
    m = fourbar(np.array([4.0, 1.0, 2.99, 2.1]), drive, given, np.ones(3)).parameter("b", 2.99)
    m = m.set({"bodies.coupler.length": "b"})
    values = [0.6, *np.linspace(2.8, 3.2, 9)]
    together = m.many({"b": values}, ["final(rocker.angle)"], 1e-3)["final(rocker.angle)"]
    assert np.isnan(together[0])
    with pytest.raises(rt.AssemblyError):
        _ = m.set(b=0.6).start
    alone = [m.set(b=float(value)).simulate(1e-3)["rocker.angle"][-1] for value in values[1:]]
    np.testing.assert_allclose(together[1:], alone, atol=1e-8)


def test_samples_with_pins_at_given_offsets_start_side_by_side_and_as_each_alone():
    """The paper's four-bar: both pins have play and offsets, so that angles given beside them are guesses."""
    m = rt.example("fourbar")
    values = np.linspace(0.55, 0.65, 5)
    together = m.many({"l2": values}, ["final(rocker.angle)"], 1e-3)
    assert "run side by side" in str(together)
    assert "one by one" not in str(together)
    for value, angle in zip(values, together["final(rocker.angle)"], strict=True):
        one = m.set(l2=float(value))
        assert one.simulate(1e-3)["rocker.angle"][-1] == pytest.approx(angle, abs=1e-9)
        r = one.simulate(1e-6)
        assert [r[f"{pin}.{key}"][0] for pin in ("O3", "O4") for key in ("ex", "ey")] == pytest.approx(
            [0.005, 0, 0.005, 0], abs=1e-12
        )


CONTACTS: list[dict[str, Any]] = [
    {},
    {"clearance": 1e-4, "contact": "massless-link"},
    {"clearance": 1e-4, "contact": {"model": "impact", "restitution": 0.5}},
]


@pytest.mark.parametrize("contact", CONTACTS, ids=["ideal", "massless-link", "impact"])
@pytest.mark.parametrize("output", ["at({}, 0)", "quantile({}, 0.5)"], ids=["at", "quantile"])
def test_samples_start_on_the_branch_and_in_the_turn_of_the_mechanism_that_they_vary(contact, output):
    """However they are run: where both closings are as near to 0, and where an angle passes 180 deg."""
    alike = fourbar(np.array([3.0, 1.0, 2.8, 1.6]), 0.0, {}, np.ones(3)).set({"joints.C": joint_c(contact)})
    alike = alike.parameter("y", 0.0).set({"ground.points.D": [3.0, "y"]})
    pin = along(math.radians(120))
    length = float(np.hypot(*(pin - [1.4, 0.2])))  # the rocker points to 180 deg
    turned = fourbar(np.array([3.0, 1.0, length, 1.6]), math.radians(120), {"coupler": -0.34}, np.ones(3))
    turned = turned.parameter("y", 0.2).set({"ground.points.D": [3.0, "y"], "joints.C": joint_c(contact)})
    for m, middle in ((alike, 0.0), (turned, 0.2)):
        for body in ("coupler", "rocker"):
            text = output.format(f"{body}.angle")
            values = m.many({"y": middle + np.array([-1e-3, -1e-5, 0.0, 1e-5, 1e-3])}, [text], 1e-5)[text]
            assert np.ptp(values) < 0.01
            assert values[2] == pytest.approx(m.simulate(1e-5)[f"{body}.angle"][0], abs=1e-3)


def joint_c(contact: dict[str, Any]) -> dict[str, Any]:
    """The joint between coupler and rocker."""
    return {"type": "revolute", "connect": ["coupler.C", "rocker.C"], **contact}


def test_a_sample_of_an_ensemble_starts_as_in_its_row():
    m = fourbar(np.array([3.0, 1.0, 2.8, 1.6]), 0.0, {}, np.ones(3)).parameter("y", 0.0, tol=1e-3)
    m = m.set({"ground.points.D": [3.0, "y"]})
    samples = m.ensemble(8, ["at(coupler.angle, 0)"], t_end=1e-4)
    for number, angle in enumerate(samples["at(coupler.angle, 0)"]):
        assert angles_of(samples.sample(number))["coupler"] == pytest.approx(angle, abs=1e-9)


def test_designs_start_on_the_branch_of_the_mechanism_that_is_optimised():
    """The angle is met at y = 0, and on the other branch nowhere."""
    m = fourbar(np.array([3.0, 1.0, 2.8, 1.6]), 0.0, {}, np.ones(3)).parameter("y", 5e-4)
    m = m.set({"ground.points.D": [3.0, "y"]})
    asked = angles_of(m.neighbour({"y": 0.0}))["coupler"]
    best = m.optimise(
        f"abs(at(coupler.angle, 0) - {asked!r})", {"y": (-1e-3, 1e-3)}, analysis="kinematics", t_end=1e-3, starts=1
    )
    assert angles_of(best.mechanism)["coupler"] == pytest.approx(asked, abs=1e-6)
    assert best.values["y"] == pytest.approx(0.0, abs=1e-5)


def test_the_closing_that_is_taken_does_not_change_with_the_masses_nor_jump_with_a_length():
    """Nothing is given but the driver: of both closings the one whose angles are nearer to 0."""
    rng = np.random.default_rng(8)
    for length in np.linspace(2.6, 3.3, 8):
        sizes = np.array([4.0, 1.0, length, 2.1])
        q = angles_of(fourbar(sizes, 0.5236, {}, rng.uniform(0.1, 10.0, 3)))
        pairs = dyad(along(0.5236, 1.0), np.array([4.0, 0.0]), float(length), 2.1)
        near = min(pairs, key=lambda pair: apart(pair[0], 0) ** 2 + apart(pair[1], 0) ** 2)
        assert (q["coupler"], q["rocker"]) == pytest.approx(near, abs=1e-9)
