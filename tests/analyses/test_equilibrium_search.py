"""The search for equilibria: complete along one degree of freedom, each position once, bounded in work, with a word."""

import math
import tomllib

import numpy as np
import pytest
from scipy.optimize import minimize

import rattle as rt
from rattle.jit import small_matrices
from rattle.questions.equilibrium import compute as equilibria
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.position import Equilibria

nojit = pytest.mark.nojit


def tree(seed: int, bodies: int, clearance: str = "") -> str:
    """Bars hung from each other at random, with springs to the ground, and a rod that closes a loop."""
    random = np.random.default_rng(seed)
    text = "format = 1\ngravity = [0, -9.81]\n[ground.points]\n"
    ground = random.uniform(-0.6, 0.6, (3, 2))
    text += "".join(f"G{k} = [{x}, {y}]\n" for k, (x, y) in enumerate(ground))
    length, angle = random.uniform(0.2, 0.6, bodies), random.uniform(-3, 3, bodies)
    ends = [ground[0]]
    initial = "[initial]\n"
    for b in range(bodies):
        parent = int(random.integers(max(0, b - 2), b)) if b else -1
        text += f'[bodies.b{b}]\nbar = ["P", "Q"]\nlength = {length[b]}\nmass = {random.uniform(0.2, 3)}\n'
        base = f"b{parent}.Q" if b else "ground.G0"
        text += f'[joints.j{b}]\ntype = "revolute"\nconnect = ["{base}", "b{b}.P"]\n'
        text += clearance if b in (1, 2) else ""
        ends.append(ends[parent + 1] + length[b] * np.array([math.cos(angle[b]), math.sin(angle[b])]))
        initial += f"b{b} = {{ angle = {angle[b]} }}\n"
    for s, b in enumerate((bodies - 1, bodies // 2)):
        text += f'[loads.s{s}]\ntype = "spring"\nconnect = ["ground.G1", "b{b}.Q"]\nstiffness = {90 * (s + 1)}\n'
        text += f"free_length = {random.uniform(0.1, 0.5)}\n"
    rod = float(np.hypot(*(ends[-1] - ground[2])))
    text += f'[joints.rod]\ntype = "rod"\nconnect = ["ground.G2", "b{bodies - 1}.Q"]\nlength = {rod}\n'
    return text + initial


PINS = 'clearance = 0.001\ncontact = "massless-link"\n'


def chain(links: int, seed: int | None = None) -> str:
    """Bars hung on each other, alike or at random; they start at random angles."""
    random = np.random.default_rng(links if seed is None else seed)
    text = "format = 1\ngravity = [0, -9.81]\n[ground.points]\nO = [0, 0]\n"
    initial = "[initial]\n"
    for k in range(links):
        length, mass = (0.3, 1.0) if seed is None else (random.uniform(0.1, 0.5), random.uniform(0.2, 3))
        text += f'[bodies.b{k}]\nbar = ["P", "Q"]\nlength = {length}\nmass = {mass}\n'
        base = f"b{k - 1}.Q" if k else "ground.O"
        text += f'[joints.j{k}]\ntype = "revolute"\nconnect = ["{base}", "b{k}.P"]\n'
        initial += f"b{k} = {{ angle = {random.uniform(-3, 3)} }}\n"
    return text + initial


# ---------------------------------------------------------------- bounded, with a word
@pytest.mark.parametrize(("seed", "bodies", "clearance"), [(1, 4, PINS), (2, 6, PINS), (3, 8, ""), (4, 10, PINS)])
def test_the_work_of_the_search_is_limited_whatever_the_mechanism(seed, bodies, clearance, monkeypatch):
    used, spent = [], []
    find = StaticProblem.find
    price = equilibria.price

    def counted(self, *arguments, **named):
        before = self.trials
        found = find(self, *arguments, **named)
        used.append(self.trials - before)
        return found

    def priced(*arguments):
        spent.append(price(*arguments))
        return spent[-1]

    monkeypatch.setattr(StaticProblem, "find", counted)
    monkeypatch.setattr(equilibria, "price", priced)
    found = rt.loads(tree(seed, bodies, clearance)).equilibrium()
    assert found[0].stable
    assert found.starts == len(used)
    assert max(used) <= equilibria.TRIALS_EACH + 1
    assert sum(spent) <= equilibria.WORK + 2 * max(spent)  # of the ideal mechanism and with play: none begun beyond
    for one in found:
        scale = max(abs(one[name]) for name in one.names if name.endswith((".fx", ".fy")))
        assert one.residual < 1e-7 * scale  # each is an equilibrium


@nojit
def test_a_search_given_up_says_so(monkeypatch):
    m = rt.example("double_pendulum")
    whole = m.equilibrium()
    assert (whole.stopped, whole.note) == (False, "")
    assert "brought nothing new" in whole.extent
    monkeypatch.setattr(equilibria, "WORK", 500.0)
    part = m.equilibrium()
    assert part.stopped
    assert part.note.startswith("search stopped after 3 starts; there may be more equilibria")
    assert part.extent == part.note
    assert 0 < len(part) <= len(whole)
    assert part.note in str(m.modes())
    assert part.note in m.equilibrium([0.0, 0.1]).trust.notes


def test_more_effort_finds_more_and_says_when_it_is_enough():
    m = rt.loads(chain(7))
    short, usual, long = (m.equilibrium(effort=effort) for effort in (0.1, 1.0, 8.0))
    assert short.stopped
    assert usual.stopped
    assert "effort 10 searches longer" in usual.note
    assert "effort 1 searches longer" in short.note
    assert len(short) < len(usual) < len(long) == 2**7
    assert not long.stopped
    for found in (short, usual, long):
        assert [one.stable for one in found[:2]] == [True, False]


@pytest.fixture(scope="module")
def arm():
    m = rt.example("balanced_arm")
    return m, m.equilibrium(effort=0.1)[0]


@nojit
@pytest.mark.parametrize("wrong", [0.0, -3.0, math.nan, math.inf, 1.0001e4, 1e308])
def test_effort_out_of_its_range_is_refused_everywhere(arm, wrong):
    m, rest = arm
    with pytest.raises(ValueError, match="effort must be"):
        m.equilibrium(effort=wrong)
    with pytest.raises(ValueError, match="effort must be"):
        m.equilibrium([0.0, 0.1], effort=wrong)
    with pytest.raises(ValueError, match="effort must be"):
        m.modes(effort=wrong)
    with pytest.raises(ValueError, match="effort must be"):
        m.modes(equilibrium=rest, effort=wrong)


@pytest.mark.long
def test_a_large_effort_finds_no_less_and_is_as_sure_as_the_usual_one():
    # what ends a search is its work: it takes more than 100 000 starts here
    found = rt.example("double_pendulum").equilibrium(effort=1600)
    assert found.starts > 100_000
    assert len(found) == 4
    assert not found.stopped
    assert "brought nothing new" in found.extent


@nojit
def test_the_advice_of_a_search_cut_short_is_an_effort_that_helps():
    m = rt.loads(chain(7))
    for tiny in (1e-300, 1e-3):
        assert "effort 1 searches longer" in m.equilibrium(effort=tiny).note
    cut = Equilibria([], 1, True, effort=5000.0)
    assert "effort 10000 searches longer" in cut.note
    assert "effort" not in Equilibria([], 1, True, effort=1e4).note


@rt.load_law("raises near the ground", c="N*m")
def raises(t, state, p):
    if state[2] > -10.0:
        raise ValueError("too deep")
    return 0.0, 0.0, p.c


@rt.load_law("raises in python", compiled=False, c="N*m")
def raises_in_python(t, state, p):
    raise ValueError("too deep")


@rt.load_law("raises when lifted", c="N*m")
def raises_when_lifted(t, state, p):
    if math.sin(state[2]) > 0.0:
        raise ValueError("no such height")
    return 0.0, 0.0, p.c


def rod_with(law):
    m = rt.Mechanism("rod", gravity=[0, -9.81]).ground(O=[0, 0])
    m.body("rod", mass=1, inertia=0.1, points={"A": [0, 0]}, center=[0.5, 0]).revolute("O", "ground.O", "rod.A")
    return m.load("L", law, body="rod", c=0)


@nojit
@pytest.mark.parametrize("law", ["raises near the ground", "raises in python"])
def test_what_a_law_raised_is_the_reason_why_no_equilibrium_was_found(law):
    m, why = rod_with(law), f"loads.L: load law '{law}' raised ValueError: too deep at t = 0 s"
    found = m.equilibrium()
    assert len(found) == 0
    assert found.note == why
    for call in (m.modes, lambda: m.equilibrium([0.0, 0.1])):
        with pytest.raises(ValueError, match="no equilibrium was found") as error:
            call()
        assert why in str(error.value)
    # driven: the position is known, the forces are not
    driven = rod_with(law).driver("motor", "O", angle="t")
    found = driven.equilibrium()
    assert [one.dof for one in found] == [0]
    assert found.note == why
    # one run later, with another load, nothing is left of it
    assert rod_with("raises when lifted").set({"loads.L": None}).equilibrium().note == ""


@nojit
def test_positions_at_which_a_law_raises_are_named_beside_those_found():
    found = rod_with("raises when lifted").equilibrium()
    assert found[0].stable
    assert found[0]["rod.angle"] == pytest.approx(-math.pi / 2, abs=1e-9)
    assert found.note == ""
    assert "no such height" in found.extent


def test_the_search_is_the_same_every_time():
    m = rt.loads(tree(6, 7))
    one, other = m.equilibrium(), m.equilibrium()
    assert one.starts == other.starts
    np.testing.assert_array_equal([e.q for e in one], [e.q for e in other])


@nojit
@pytest.mark.parametrize(
    ("model", "said"),
    [
        ("balanced_arm", "nothing new"),
        ("guide_play", "one degree of freedom was searched"),
        ("fourbar", "no degree of freedom"),
    ],
)
def test_how_far_the_search_went_is_said(model, said):
    found = rt.example(model).equilibrium()
    assert said in found.extent
    assert ("either side" in found.extent) == (model == "fourbar")


# ---------------------------------------------------------------- the stable ones are there
@pytest.mark.parametrize("seed", [None, 3])
def test_every_link_of_a_pendulum_may_hang_or_stand(seed):
    found = rt.loads(chain(5, seed)).equilibrium()
    up = {tuple(round(math.sin(one[f"b{k}.angle"])) for k in range(5)) for one in found}
    assert len(found) == len(up) == 2**5
    assert [all(math.sin(one[f"b{k}.angle"]) < 0 for k in range(5)) for one in found] == [True] + 31 * [False]
    assert [one.stable for one in found] == [True] + 31 * [False]


@pytest.mark.parametrize(("model", "ways"), [("squeezer", 8), ("windows", 12)])
def test_with_one_freedom_other_ways_to_put_it_together_are_met(model, ways):
    found = rt.example(model).equilibrium()
    assert len(found) == ways  # as many as ten times the starts find with branches="all"
    assert "end to end" in found.extent


def test_the_stable_positions_with_play_are_those_without_it_pins_pressing():
    for contact in ('"impact"', '{ model = "hertz", stiffness = 1e7, exponent = 1.5, bush_radius = 0.02 }'):
        play = f"clearance = 0.001\ncontact = {contact}\n"
        text = chain(6).replace('type = "revolute"\n', f'type = "revolute"\n{play}')
        found = rt.loads(text).equilibrium()
        assert [one.stable and one.admissible for one in found] == [True] + [False] * (len(found) - 1)
        first = found[0]
        for k in range(6):  # hanging straight down, pin k a clearance and what it sinks in below its bush
            assert math.sin(first[f"b{k}.angle"]) == pytest.approx(-1.0)
            assert first[f"j{k}.normal"] == pytest.approx((6 - k) * 9.81, rel=1e-9)
            assert first[f"j{k}.ey"] == pytest.approx(-0.001 - first[f"j{k}.penetration"], abs=1e-12)
        if "hertz" in contact:
            assert first["j0.penetration"] == pytest.approx((6 * 9.81 / 1e7) ** (2 / 3), rel=1e-6)


def test_ten_links_hang_straight_down_and_swing_as_their_matrices_say():
    m = rt.loads(chain(10))
    found = m.equilibrium()
    assert found[0].stable
    assert not any(one.stable for one in found[1:])
    np.testing.assert_allclose([math.sin(found[0][f"b{k}.angle"]) for k in range(10)], -1, atol=1e-14)
    below = 9 - np.arange(10)  # links below each; M and K of small angles, rods of 1 kg and 0.3 m
    mass = 0.09 * (0.5 + np.minimum.outer(below, below)) + np.diag(0.09 * (1 / 3 - 0.5) * np.ones(10))
    stiffness = 9.81 * 0.3 * np.diag(0.5 + below)
    squares = np.linalg.eigvals(np.linalg.solve(mass, stiffness))
    np.testing.assert_allclose(m.modes().omega, np.sqrt(np.sort(squares.real)), rtol=1e-8)


def test_a_chain_between_two_supports_hangs_or_stands_as_a_polygon_of_forces():
    links, span = 8, 0.8 * 8 * 0.3
    text, initial = chain(links).split("[initial]")
    angles = np.arccos(np.clip(span / (links * 0.3), -1, 1)) * np.linspace(-1.2, 1.2, links)
    initial = "".join(f"b{k} = {{ angle = {angle} }}\n" for k, angle in enumerate(angles))
    text = text.replace("O = [0, 0]", f"O = [0, 0]\nE = [{span}, 0]")
    text += f'[joints.end]\ntype = "revolute"\nconnect = ["ground.E", "b{links - 1}.Q"]\n[initial]\n{initial}'
    found = rt.loads(text).equilibrium()
    assert [one.stable for one in found[:2]] == [True, False]
    # V grows by m g at every pin and H is the same everywhere: the tangents are evenly spaced
    for one in found[:2]:
        tangent = np.array([math.tan(one[f"b{k}.angle"]) for k in range(links)])
        np.testing.assert_allclose(np.diff(tangent), 9.81 / one["end.fx"], rtol=1e-8)
    assert found[0]["b3.y"] == pytest.approx(-found[1]["b3.y"], abs=1e-9)  # the chain and its arch


def lowest(text: str, starts: int) -> float:
    """Least potential energy of a `tree` over its angles, by SciPy from random starts [J]."""
    model = tomllib.loads(text)
    bodies, ground = list(model["bodies"].values()), model["ground"]["points"]
    length, mass = (np.array([body[key] for body in bodies]) for key in ("length", "mass"))
    parents = [joint["connect"][0] for name, joint in model["joints"].items() if name != "rod"]

    def ends(angles):
        at = []
        for base, angle, reach in zip(parents, angles, length, strict=True):
            owner, point = base.split(".")
            start = np.array(ground[point]) if owner == "ground" else at[int(owner[1:])]
            at.append(start + reach * np.array([math.cos(angle), math.sin(angle)]))
        return np.array(at)

    def energy(angles):
        at = ends(angles)
        value = 9.81 * float(mass @ (at[:, 1] - 0.5 * length * np.sin(angles)))
        for spring in model["loads"].values():
            anchor, body = (end.split(".") for end in spring["connect"])
            stretch = np.hypot(*(at[int(body[0][1:])] - ground[anchor[1]])) - spring["free_length"]
            value += 0.5 * spring["stiffness"] * stretch**2
        return value

    rod = model["joints"]["rod"]
    closed = {"type": "eq", "fun": lambda angles: np.hypot(*(ends(angles)[-1] - ground["G2"])) - rod["length"]}
    random, found = np.random.default_rng(1), []
    for _ in range(starts):
        start = random.uniform(-math.pi, math.pi, len(bodies))
        done = minimize(energy, start, method="SLSQP", constraints=[closed], options={"maxiter": 300, "ftol": 1e-10})
        found += [done.fun] if done.success and abs(closed["fun"](done.x)) < 1e-8 else []
    return min(found)


@pytest.mark.parametrize(("seed", "bodies"), [(104, 7), (105, 8), (107, 10), (128, 7), (131, 10), (139, 10)])
def test_the_lowest_position_of_rest_is_always_found(seed, bodies):
    found = rt.loads(tree(seed, bodies)).equilibrium()
    stable = min(one["energy.potential"] for one in found if one.stable)
    assert stable <= lowest(tree(seed, bodies), 8) + 1e-4  # SciPy's own accuracy


def test_whole_turns_count_where_a_spring_is_wound_and_nowhere_else():
    found = rt.loads(chain(4)).equilibrium()
    start = rt.loads(chain(4)).start.q
    assert max(np.abs(one.q - start)[2::3].max() for one in found) <= math.pi + 1e-9
    twist = '[loads.twist]\ntype = "torsion-spring"\nconnect = ["ground", "b0"]\nstiffness = 0.1\n'
    found = rt.loads(chain(2).replace("[initial]", twist + "[initial]")).equilibrium()
    for one in found:  # torque of the weights about O: m g L (1/2 + 1) cos(angle), held by the spring
        assert 9.81 * 0.3 * 1.5 * math.cos(one["b0.angle"]) == pytest.approx(-0.1 * one["b0.angle"], abs=1e-9)


# ---------------------------------------------------------------- complete and without doubles
def test_no_position_is_listed_twice():
    found = rt.loads(tree(5, 4, PINS)).equilibrium()
    assert len(found) > 4
    for k, one in enumerate(found):
        for other in found[:k]:
            apart = one.q - other.q
            apart[2::3] = (apart[2::3] + math.pi) % (2 * math.pi) - math.pi
            assert np.abs(apart).max() > 1e-6  # a thousandth of the play


@nojit
def test_a_walk_around_one_freedom_finds_every_change_of_sign():
    # torque of the weight against a spring over the angle: closed form, roots counted on a fine grid
    k, length, h = 60.0, 0.25, 0.8
    text = f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
S = [0.3, {h}]
[bodies.rod]
bar = ["T", "B"]
length = 1
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.T"]
[loads.spring]
type = "spring"
connect = ["ground.S", "rod.B"]
stiffness = {k}
free_length = {length}
[initial]
rod = {{ angle = 2.9 }}
"""
    phi = np.linspace(-math.pi, math.pi, 200001)
    d = np.hypot(np.cos(phi) - 0.3, np.sin(phi) - h)
    energy = 9.81 * 0.5 * np.sin(phi) + 0.5 * k * (d - length) ** 2
    slope = np.diff(energy)
    roots = phi[1:-1][slope[:-1] * slope[1:] < 0]
    found = sorted((one["rod.angle"] + math.pi) % (2 * math.pi) - math.pi for one in rt.loads(text).equilibrium())
    assert len(roots) == 4
    np.testing.assert_allclose(found, roots, atol=1e-4)  # the grid's own spacing is 3e-5 rad


@nojit
def test_where_the_stiffness_vanishes_is_no_rest():
    found = rt.example("guide_play").equilibrium()  # starts where weight and geometry make H exactly zero
    assert all(one.residual < 1e-6 for one in found)


# ---------------------------------------------------------------- linear algebra
@nojit
@pytest.mark.parametrize(("rows", "n", "rank"), [(4, 7, 4), (6, 7, 3), (7, 5, 5), (1, 3, 1), (0, 3, 0)])
def test_rank_null_space_and_least_squares_are_those_of_numpy(rows, n, rank):
    random = np.random.default_rng(rows)
    a = random.normal(size=(rows, rank)) @ random.normal(size=(rank, n))
    wide, order, pivot = a.copy(), np.zeros(rows, np.int64), np.zeros((2, rows))
    assert small_matrices.triangulate(wide, rows, order, pivot, 1e-9) == rank
    basis = np.eye(n)
    for line in basis:
        small_matrices.out_of_basis(wide, pivot, rank, line)
    np.testing.assert_allclose(basis @ basis.T, np.eye(n), atol=1e-14)
    np.testing.assert_allclose(a @ basis[rank:].T, np.zeros((rows, n - rank)), atol=1e-13)
    if rank == rows:  # the multipliers of a force, by least squares
        force = random.normal(size=n)
        work = force.copy()
        small_matrices.into_basis(wide, pivot, rank, work)
        small_matrices.solve_upper(wide, pivot, rank, work)
        wanted = np.linalg.lstsq(a.T, force, rcond=None)[0] if rows else np.zeros(0)
        np.testing.assert_allclose(work[:rank], wanted[order], atol=1e-13)


@nojit
def test_the_absolute_value_of_a_symmetric_matrix_is_inverted():
    random = np.random.default_rng(4)
    basis = np.linalg.qr(random.normal(size=(5, 5)))[0]
    values = np.array([3.0, -2.0, 2.0, -1e-3, 0.4])  # the pair of equal size is the hard case
    small, right, x = np.zeros((10, 5)), random.normal(size=5), np.zeros(5)
    small[:5] = basis @ np.diag(values) @ basis.T
    small_matrices.rotate_columns(small, 5)
    small_matrices.solve_downhill(small, 5, right, 1e-9, x)
    np.testing.assert_allclose(x, basis @ ((basis.T @ right) / np.abs(values)), rtol=1e-11)


@nojit
def test_a_square_system_leaves_out_what_depends_on_the_rest():
    h = np.array([[2.0, 1.0, 3.0], [1.0, 4.0, 5.0], [0.5, 1.0, 1.5]])  # last column: sum of the others
    small, right = np.zeros((6, 6)), h @ np.array([0.3, -0.2, 0.1])
    small[:3, :3] = h.T
    order, pivot, work, x = np.zeros(6, np.int64), np.zeros((2, 6)), np.zeros(6), np.zeros(6)
    small_matrices.solve_square(small, 3, order, pivot, right, 1e-13, work, x)
    np.testing.assert_allclose(h @ x[:3], right, atol=1e-14)
    assert (x[:3] == 0.0).sum() == 1
