"""Samples side by side: order of the methods, closed forms of every reduction, the same bits in any company."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.analyses.straight_line.machine_code import MachineFunctions
from rattle.registry import kinds
from rattle.solvers.step_size import SAFETY
from rattle.trace.copying import replaced
from rattle.trace.elementary import lower
from rattle.trace.graph import NUMPY, Graph
from rattle.trace.lane_batch import Batch
from rattle.trace.lane_control import Status
from rattle.trace.lane_methods import Method, Tolerances
from rattle.trace.lane_program import Model, Program
from rattle.trace.lanes import run
from rattle.trace.reductions import Reduction

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
DOP853, RK4 = (Method(kinds("stepper")[name].leaf.tableau) for name in ("dop853", "rk4"))
FINE = Tolerances(1e-11, 1e-13)
W = np.linspace(0.7, 7.3, 24)  # angular frequencies [1/s]
T = 2.0  # [s]


def compiled(graph, outputs):
    """`Graph.evaluate` for many calls: its operations are put in order once."""
    rank = {place: n for n, place in enumerate(graph.inputs)}
    places = [graph.place(x) for x in outputs]
    work = [
        (place, NUMPY[graph.ops[place]], graph.operands[place])
        for place in graph.live(outputs)
        if graph.ops[place] not in ("input", "number")
    ]
    numbers = {place: np.float64(x) for place, x in graph.numbers.items()}

    def call(rows, out):
        assert rows.shape[0] == len(rank)
        assert out.shape == (len(places), rows.shape[1])
        assert rows[0].flags.c_contiguous
        assert out[0].flags.c_contiguous
        assert not np.shares_memory(rows, out)
        values = dict(numbers)
        for place, n in rank.items():
            values[place] = rows[n]
        with np.errstate(all="ignore"):
            for place, function, operands in work:
                values[place] = function(*(values[k] for k in operands))
        for n, place in enumerate(places):
            out[n] = values[place]

    return call


def test_this_executor_is_graph_evaluate():
    """So that the bits compared below are those of the reference."""
    random = np.random.default_rng(1)
    graph = Graph()
    a, b = graph.input(), graph.input()
    outputs = [a / b, graph.apply("sqrt", abs(a)) < b, 2.0]
    rows, out = random.normal(size=(2, 100)), np.empty((3, 100))
    compiled(graph, outputs)(rows, out)
    assert (out == graph.evaluate(outputs, rows)).all()


def lowered(graph, outputs):
    return compiled(*lower(graph, outputs))


def oscillator(sound=None, curves=lambda x, v, w, t: [x, v], lowered=lowered, watched=True, sound_curves=None):
    """x'' = -w^2 x with x = 1, x' = 0 at first; parameter w.  sound(t, x, v, w): a flag of the right-hand side.

    lowered: what compiles its functions.  watched: stages show its curves.  sound_curves: as sound, of the curves.
    """
    graph = Graph()
    t, x, v, w = (graph.input() for _ in range(4))
    shown = curves(x, v, w, t)
    flag, sound_curves = (1.0 if one is None else one(t, x, v, w) for one in (sound, sound_curves))

    def begin(p):
        one = np.ones(p.shape[1])
        return np.array([one, 0.0 * one]), p[:1], p[0] > 0.0

    return Model(
        ny=2, nc=1, curves=len(shown), motion=2, controlled=(0, 1), begin=begin,
        rate=lowered(graph, [v, -(w * w) * x, flag]), project=lowered(graph, [x, v, 1.0]),
        outputs=lowered(graph, [*shown, sound_curves]),
        watch=lowered(graph, [v, -(w * w) * x, flag, *shown]), watched=tuple(range(len(shown))) if watched else (),
    )  # fmt: skip


def pendulum(damping=0.0):
    """phi'' = -g/l sin phi - damping phi' from rest at phi0; parameters l, g, phi0; damping that no energy knows of."""
    graph = Graph()
    _, phi, omega, l, g, total = (graph.input() for _ in range(6))
    sine, cosine = (graph.apply(name, phi) for name in ("sin", "cos"))
    kinetic, potential = 0.5 * (l * omega) ** 2, -(g * l) * cosine

    def begin(p):
        l, g, phi0 = p
        return np.array([phi0, 0.0 * phi0]), np.array([l, g, -g * l * np.cos(phi0)]), l > 0.0

    return Model(
        ny=2, nc=3, curves=6, motion=2, controlled=(0, 1), begin=begin,
        rate=lowered(graph, [omega, -(g / l) * sine - damping * omega * (g > 9.0), 1.0]),
        project=lowered(graph, [phi, omega, 1.0]),
        outputs=lowered(graph, [phi, kinetic, potential, 0.0, 0.0, kinetic + potential - total, 1.0]),
        energies=(1, 2, 3, 4, 5),
    )  # fmt: skip


def circle(together=False):
    """A point on a circle of radius r with constant speed v; parameters r, v.

    together: one function projects and computes slopes and curves there.
    """
    graph = Graph()
    _, x, y, vx, vy, r = (graph.input() for _ in range(6))
    pull = -(vx * vx + vy * vy) / (r * r)
    size = graph.apply("sqrt", x * x + y * y)
    along = (x * vx + y * vy) / (size * size)

    def begin(p):
        zero = 0.0 * p[0]
        return np.array([p[0], zero, zero, p[1]]), p[:1], p[0] > 0.0

    rate, shown = [vx, vy, pull * x, pull * y, 1.0], [x, size - r, x * vx + y * vy, 1.0]
    closed = [x * r / size, y * r / size, vx - along * x, vy - along * y, 1.0]
    there = replaced(graph, [*rate, *shown], dict(zip(graph.inputs[1:], closed[:-1], strict=False)))
    return Model(
        ny=4, nc=1, curves=3, motion=4, controlled=(0, 1, 2, 3), begin=begin,
        rate=lowered(graph, rate), project=None if together else lowered(graph, closed), outputs=lowered(graph, shown),
        arrive=lowered(graph, [*closed, *there]) if together else None,
    )  # fmt: skip


def values(model, reductions, parameters, method=DOP853, t_end=T, width=32, **settings):
    settings = {"tolerances": FINE, "step": 2e-3} | settings
    program = Program(model, lowered, method, reductions, t_end, **settings)
    outcome = run(program, np.atleast_2d(parameters), width=width)
    assert (outcome.status == Status.DONE).all(), outcome.status
    return outcome.values


# ---------------------------------------------------------------- accuracy
@pytest.mark.parametrize(("method", "order", "parts"), [(RK4, 4, 40), (DOP853, 8, 8)])
def test_a_method_has_its_order(method, order, parts):
    w, errors = np.array([2.0, 3.0, 5.0]), []
    for n in (parts, 2 * parts):
        settings = {"tolerances": Tolerances(1.0, 1.0, T / n), "step": T / n}  # every step may have the largest length
        x, v = values(oscillator(), [Reduction("final", 0), Reduction("final", 1)], w, method, **settings)
        errors.append(np.hypot(x - np.cos(w * T), v / w + np.sin(w * T)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


def test_errors_follow_the_tolerance():
    for rtol in (1e-5, 1e-8, 1e-11):
        final = values(oscillator(), [Reduction("final", 0)], W, tolerances=Tolerances(rtol, rtol / 100))[0]
        assert np.abs(final - np.cos(W * T)).max() < 10 * rtol


@pytest.mark.parametrize(("method", "error"), [(DOP853, 2e-10), (RK4, 2e-8)])
def test_reductions_have_the_values_of_closed_forms(method, error):
    """x = cos(wt) and x - 1/2; errors: of the motion with FINE, and h^4 w^4 T with 2 ms."""
    model = oscillator(curves=lambda x, v, w, t: [x, v, x - 0.5])
    whole = ["max", "min", "range", "mean", "integral", "rms", "sd"]
    reductions = [
        *(Reduction(kind, 0) for kind in whole), *(Reduction("at", 0, t) for t in (0.7, 0.0, T)),
        Reduction("final", 0), Reduction("share", 2), Reduction("first", 2), Reduction("first", 1),
    ]  # fmt: skip
    made = values(model, reductions, W, method)
    low = np.where(math.pi < W * T, -1.0, np.cos(W * T))
    back = 2 * math.pi < W * T
    high = np.ones_like(W)
    integral = np.sin(W * T) / W
    square = 0.5 + np.sin(2 * W * T) / (4 * W * T)
    turns, rest = np.divmod(W * T, 2 * math.pi)
    third = math.pi / 3
    on = 2 * third * turns + np.minimum(rest, third) + np.maximum(rest - 5 * third, 0.0)
    true = [
        high, low, high - low, integral / T, integral, np.sqrt(square), np.sqrt(square - (integral / T) ** 2),
        np.cos(0.7 * W), high, np.cos(W * T), np.cos(W * T), on / (W * T), 0.0 * W,
        np.where(math.pi < W * T, math.pi / W, np.nan),
    ]  # fmt: skip
    assert back.any()  # some samples see a maximum inside a step, and a condition that begins again
    for one, got, want in zip(reductions, made, true, strict=True):
        assert (np.isnan(got) == np.isnan(want)).all(), one
        assert np.nanmax(np.abs(got - want)) < error, one


def test_a_maximum_inside_a_step_is_as_good_as_the_motion():
    """x + 0.3 v rises from 1 to sqrt(1 + (0.3 w)^2) at tan(wt) = -0.3 w + ..., inside a step of some radians."""
    model = oscillator(curves=lambda x, v, w, t: [x - 0.3 * v])
    made = values(model, [Reduction("max", 0)], W, tolerances=Tolerances(1e-8, 1e-10))[0]
    at = np.arctan(0.3 * W) / W  # < T for all
    assert np.abs(made - np.sqrt(1.0 + (0.3 * W) ** 2)).max() < 1e-7
    assert (at < T).all()


def test_a_kink_raises_no_maximum():
    """The polynomial through samples on both sides of the zero of |x| would go 0.006 below it; |v|/w is smooth at 1."""
    model = oscillator(curves=lambda x, v, w, t: [abs(x), abs(v) / w])
    low, top = values(model, [Reduction("min", 0), Reduction("max", 1)], W, tolerances=Tolerances(1e-8, 1e-10))
    crosses = math.pi / 2 < W * T
    assert (low[crosses] > -1e-8).all()
    assert low[~crosses] == pytest.approx(np.cos(W * T)[~crosses], abs=1e-7)
    assert np.abs(top - np.where(crosses, 1.0, np.sin(W * T))).max() < 1e-7


def test_conditions_with_many_crossings_and_kinks_are_timed_to_rounding():
    """sin 9t < 0 and |sin 9t| > 1/2: up to two crossings in a step of the slow motion, kinks between them."""

    def curves(x, v, w, t):
        wave = t.graph.apply("sin", 9.0 * t)
        return [-wave, abs(wave) - 0.5]

    kinds = [Reduction(kind, n) for n in (0, 1) for kind in ("share", "first")]
    made = values(oscillator(curves=curves), kinds, [[1.0, 2.0]])
    turns, rest = divmod(9.0 * T, 2 * math.pi)
    below = turns * math.pi + max(rest - math.pi, 0.0)
    halves, rest = divmod(9.0 * T, math.pi)
    outside = halves * 2 * math.pi / 3 + min(max(rest - math.pi / 6, 0.0), 2 * math.pi / 3)
    true = [below / (9.0 * T), math.pi / 9.0, outside / (9.0 * T), math.pi / 54.0]
    for got, want in zip(made, true, strict=True):
        assert got == pytest.approx(want, abs=1e-10)


def test_a_condition_that_never_or_always_holds():
    model = oscillator(curves=lambda x, v, w, t: [x - 2.0, x + 2.0])
    kinds = [Reduction(kind, n) for n in (0, 1) for kind in ("share", "first")]
    never, nan, always, zero = values(model, kinds, W)
    assert (never == 0.0).all()
    assert np.isnan(nan).all()
    assert always == pytest.approx(1.0, abs=1e-14)
    assert (zero == 0.0).all()


def test_pendulums_swing_with_their_period_and_amplitude():
    """From 2 rad at rest the pendulum is there again after 4 sqrt(l/g) K(sin(1)), by the arithmetic-geometric mean."""
    l, g = np.array([0.3, 0.7, 1.1]), 9.81
    a, b = 1.0, math.cos(1.0)
    for _ in range(8):
        a, b = (a + b) / 2, math.sqrt(a * b)
    for n, period in enumerate(2 * math.pi * np.sqrt(l / g) / a):
        parameters = [[l[n]], [g], [2.0]]
        kinds = [Reduction("final", 0), Reduction("min", 0), Reduction("mean", 0)]
        final, least, mean = values(pendulum(), kinds, parameters, t_end=period)
        assert final[0] == pytest.approx(2.0, abs=1e-8)
        assert least[0] == pytest.approx(-2.0, abs=1e-8)
        assert mean[0] == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("method", [DOP853, RK4])
def test_steps_end_on_the_constraint(method):
    parameters = np.array([[0.5, 1.0, 2.0], [1.0, 2.0, 3.0]])
    kinds = [Reduction("final", 0), Reduction("final", 1), Reduction("final", 2)]
    x, off, turning = values(circle(), kinds, parameters, method, step=1e-3, tolerances=Tolerances(1e-9, 1e-11))
    r, v = parameters
    assert np.abs(x - r * np.cos(v / r * T)).max() < 1e-7
    assert np.abs(off).max() < 1e-15
    assert np.abs(turning).max() < 1e-14


@pytest.mark.parametrize("method", [DOP853, RK4])
def test_the_end_of_a_step_has_the_same_bits_from_one_function(method):
    """Of projection, slopes and curves, as from one after the other."""
    parameters = np.array([[0.5, 1.0, 2.0], [1.0, 2.0, 3.0]])
    kinds = [*(Reduction("final", n) for n in range(3)), Reduction("max", 0), Reduction("mean", 0)]
    settings = {"step": 1e-2, "tolerances": Tolerances(1e-6, 1e-8)}
    one, other = (values(circle(together), kinds, parameters, method, **settings) for together in (False, True))
    assert (one == other).all()


def recorded(model, names):
    """A model of the package at its start, which has no parameters, and the curves of these names."""
    made = model.recorded()
    energies = [f"energy.{name}" for name in ("kinetic", "potential", "work", "dissipated", "balance")]
    shown = [*names, *energies]
    ny, start = made.state_size, made.start_state
    motion = ny - 2  # then work and energy dissipated
    at_first = np.concatenate([[made.start.t], start, [0.0]])[:, None]  # the last one is the energy at the start
    graph, balance = lower(made.graph, [made.curves["energy.balance"]])
    energy = graph.evaluate(balance, at_first)

    def begin(p):
        one = np.ones(p.shape[1])
        return start[:, None] * one, energy * one, one > 0.0

    return Model(
        ny=ny, nc=1, curves=len(shown), motion=motion, controlled=tuple(range(motion)), begin=begin,
        rate=lowered(made.graph, made.derivative), project=lowered(made.graph, made.projection),
        outputs=lowered(made.graph, [*(made.curves[name] for name in shown), made.sound_curves]),
        energies=tuple(range(len(names), len(shown))),
    )  # fmt: skip


def top(curve):
    """The largest of equally spaced values, or the vertex of the parabola through it and its neighbours."""
    k = int(curve.argmax())
    if not 0 < k < len(curve) - 1:
        return curve[k]
    slope, bend = 0.5 * (curve[k + 1] - curve[k - 1]), curve[k + 1] - 2.0 * curve[k] + curve[k - 1]
    return curve[k] - 0.5 * slope * slope / bend


def test_the_four_bar_moves_as_the_package_simulates_it():
    """Landed states agree to some tolerances; extremes and means to the error of the parabola and of Simpson's rule."""
    m, t_end = rt.example("fourbar"), 0.005
    names = ["crank.angle", "rocker.omega", "coupler.x", "O3.normal", "O4.fx", "motor.torque"]
    kinds = ("at", "final", "max", "min", "mean")
    reductions = [Reduction(kind, n, 0.3 * t_end) for n in range(len(names)) for kind in kinds]
    tight = Tolerances(1e-10, 1e-12)
    made = values(recorded(m, names), reductions, np.zeros((1, 2)), t_end=t_end, width=8, tolerances=tight)
    assert (made[:, 0] == made[:, 1]).all()
    motion = m.simulate(t_eval=np.linspace(0.0, t_end, 501), rtol=1e-10)
    simpson = np.array([1.0, *[4.0, 2.0] * 249, 4.0, 1.0]) / 1500.0
    for n, name in enumerate(names):
        curve = motion[name]
        scale, got = np.abs(curve).max(), made[5 * n : 5 * n + 5, 0]
        assert got[:2] == pytest.approx([curve[150], curve[-1]], abs=1e-8 * scale), name
        assert got[2:4] == pytest.approx([top(curve), -top(-curve)], abs=1e-5 * scale), name
        assert got[4] == pytest.approx(simpson @ curve, abs=1e-6 * scale), name


def test_the_four_bar_takes_the_steps_of_the_package():
    """Errors, projections and step lengths follow the same rules but for the safety; rounding may turn one decision."""
    m, t_end = rt.example("fourbar"), 0.005
    model = recorded(m, ["crank.angle"])
    alike = Method(DOP853.tableau, SAFETY)
    outcome = run(Program(model, lowered, alike, [Reduction("final", 0)], t_end), np.zeros((1, 1)))
    stats = m.simulate(t_eval=[0.0, t_end], rtol=1e-8).stats
    tries = (outcome.tallies.evaluations - 2) / 12
    assert abs(int(outcome.steps[0]) - stats["steps"]) <= 1
    assert abs(tries - outcome.steps[0] - stats["rejected"]) <= 1
    assert stats["rejected"] > 0


# ---------------------------------------------------------------- independence
def bits(program, parameters, **settings):
    outcome = run(program, parameters, **settings)
    return [np.ascontiguousarray(one).view(np.uint8).tobytes() for one in outcome[:3]], outcome


ALL = [
    *(Reduction(kind, 0) for kind in ("max", "min", "mean", "rms", "sd", "final")),
    Reduction("at", 0, 0.3), Reduction("share", 1), Reduction("first", 1),
]  # fmt: skip


@pytest.mark.parametrize("kinds", ["some sampled", "conditions"])
@pytest.mark.parametrize("method", [DOP853, RK4])
def test_a_sample_has_the_same_bits_in_any_company(method, kinds):
    """Whatever the width, the order and the threads; some samples fail, many more than fit in at once are waiting."""
    model = oscillator(sound=lambda t, x, v, w: (x > -0.9) | (w < 4.0), curves=lambda x, v, w, t: [x, v + 1.0])
    w = np.random.default_rng(3).permutation(np.concatenate([np.linspace(0.5, 7.0, 24), [-1.0]]))[None]
    program = Program(model, lowered, method, KINDS[kinds], T, tolerances=Tolerances(1e-6, 1e-8), step=0.1)
    whole, outcome = bits(program, w, width=64)
    assert set(outcome.status) == {Status.DONE, Status.ASSUMPTION, Status.START}
    for width in (1, 8):
        assert bits(program, w, width=width)[0] == whole
    assert bits(program, w, width=8, threads=2)[0] == whole
    order = np.random.default_rng(4).permutation(w.shape[1])
    mixed = run(program, w[:, order], width=16)
    for one, other in zip(outcome[:3], mixed[:3], strict=True):
        assert np.array_equal(one[..., order], other, equal_nan=True)
    assert mixed.tallies.evaluations == outcome.tallies.evaluations


@pytest.mark.parametrize("method", [DOP853, RK4])
def test_extremes_are_those_of_steps_that_are_all_sampled(method):
    """Bit for bit, though only steps are sampled that can hold one; long steps, kinks, and a curve that swings fast."""

    def curves(x, v, w, t):
        return [x, abs(v), x * v, t.graph.apply("sin", 9.0 * t) + 0.1 * x]

    kinds = [Reduction(kind, n) for n, kind in enumerate(("range", "max", "max", "min"))]
    for asked, rtol in ((kinds, 1e-5), (kinds[:1], 1e-10)):
        outcomes, settings = [], {"tolerances": Tolerances(rtol, rtol / 100), "step": 0.1}
        for watched in (True, False):
            program = Program(oscillator(curves=curves, watched=watched), lowered, method, asked, T, **settings)
            assert bool(program.ledger.watched) == watched
            outcomes.append(run(program, W[None], width=8))
        assert np.array_equal(outcomes[0].values, outcomes[1].values)
    if method is DOP853:  # has stages for samples alone
        assert outcomes[0].tallies.evaluations < 0.95 * outcomes[1].tallies.evaluations


def test_samples_on_broken_assumptions_end_the_sample():
    """The curve is not sound at 1.75 s, amid the last step: only cos 3t, which rises there, is looked at."""
    model = oscillator(sound_curves=lambda t, x, v, w: abs(t - 1.75) > 0.05)
    outcome = run(
        Program(model, lowered, RK4, [Reduction("max", 0)], T, step=0.5), np.array([[1.5, 3.0, 1.0]]), width=8
    )
    assert outcome.status.tolist() == [Status.DONE, Status.ASSUMPTION, Status.DONE]
    assert outcome.values[0, [0, 2]].tolist() == [1.0, 1.0]
    assert np.isnan(outcome.values[0, 1])


MIXED = {
    "sound": lambda t, x, v, w: (x > -0.9) | (w < 4.0),
    "curves": lambda x, v, w, t: [x, v + 1.0],
}


KINDS = {
    "conditions": ALL,
    "all sampled": [one for one in ALL if one.curve == 0],
    "some sampled": [Reduction("max", 0), Reduction("range", 1), Reduction("at", 0, 0.3)],
}


@pytest.mark.parametrize("kinds", KINDS.values(), ids=KINDS)
@pytest.mark.parametrize("method", [DOP853, RK4])
def test_steps_in_tiles_of_machine_code_have_the_same_bits(method, kinds):
    """Many steps in one call, however many, tile by tile, by one thread and two: as NumPy takes them one by one."""
    w = np.random.default_rng(5).permutation(np.concatenate([np.linspace(0.5, 7.0, 203), [-1.0]]))[None]
    settings = {"tolerances": Tolerances(1e-6, 1e-8), "step": 0.1}
    whole, outcome = bits(Program(oscillator(**MIXED), lowered, method, kinds, T, **settings), w, width=208, looks=1)
    assert set(outcome.status) == {Status.DONE, Status.ASSUMPTION, Status.START}
    functions = MachineFunctions()
    model = oscillator(**MIXED, lowered=lambda graph, outputs: functions.add(*lower(graph, outputs)))
    program = Program(model, functions.add, method, kinds, T, **settings, chain=functions.chain, tiled=True)
    functions.compile()
    for width, looks, threads in ((208, 1, 1), (208, 8, 1), (48, 3, 1), (8, 100, 1), (64, 8, 2)):
        found, again = bits(program, w, width=width, looks=looks, threads=threads)
        assert found == whole, (width, looks, threads)
        assert again.tallies.evaluations == outcome.tallies.evaluations


def test_tiles_are_independent():
    """As the chain that Python makes works on them."""
    w = np.linspace(0.5, 7.0, 150)[None]
    programs = [Program(oscillator(**MIXED), lowered, DOP853, ALL, T, tiled=tiled) for tiled in (False, True)]
    assert len(Batch(programs[1], 152, 1).memory) > 1
    one, other = (bits(program, w, width=152, looks=4)[0] for program in programs)
    assert one == other


def test_progress_counts_every_sample_once():
    seen = []
    program = Program(oscillator(), lowered, DOP853, [Reduction("final", 0)], T)
    run(
        program, np.linspace(-1.0, 5.0, 50)[None], width=8, threads=2, progress=lambda done, of: seen.append((done, of))
    )
    assert seen[-1] == (50, 50)
    assert [one[0] for one in seen] == sorted({one[0] for one in seen})


def test_an_error_in_a_thread_reaches_the_caller():
    def fail(done, of):
        raise KeyboardInterrupt

    program = Program(oscillator(), lowered, DOP853, [Reduction("final", 0)], T)
    with pytest.raises(KeyboardInterrupt):
        run(program, np.linspace(1.0, 5.0, 50)[None], width=8, threads=2, progress=fail)


# ---------------------------------------------------------------- failures
def failing(model, parameters, method=DOP853, **settings):
    """Status of samples, of which those with good neighbours keep their values."""
    program = Program(model, lowered, method, [Reduction("final", 0)], T, **settings)
    outcome = run(program, np.atleast_2d(parameters), width=4)
    assert np.isnan(outcome.values[0, outcome.status != Status.DONE]).all()
    assert np.isfinite(outcome.values[0, outcome.status == Status.DONE]).all()
    return outcome


def test_a_broken_assumption_ends_only_the_sample_that_makes_it():
    """x reaches -0.5 at wt = 2 pi/3."""
    outcome = failing(oscillator(sound=lambda t, x, v, w: x > -0.5), W)
    assert (outcome.status == np.where(2 * math.pi / 3 < W * T, Status.ASSUMPTION, Status.DONE)).all()
    good = outcome.status == Status.DONE
    assert outcome.values[0, good] == pytest.approx(np.cos(W * T)[good], abs=1e-6)


@pytest.mark.parametrize(
    ("method", "status"), [(DOP853, Status.STEP_TOO_SMALL), (RK4, Status.NOT_FINITE)], ids=["dop853", "rk4"]
)
def test_a_load_outside_its_domain_ends_a_sample(method, status):
    """sqrt(4 - wt) has no value after t = 4/w: adaptive steps become short before it, equal ones go beyond."""
    graph = Graph()
    t, x, v, w = (graph.input() for _ in range(4))
    root = graph.apply("sqrt", 4.0 - w * t)
    model = oscillator()._replace(rate=lowered(graph, [v, root - x, 1.0]))
    outcome = failing(model, W, method, step=1e-2)
    assert (outcome.status == np.where(W * T > 4.0, status, Status.DONE)).all()


def test_an_energy_that_is_not_accounted_for_ends_a_sample():
    parameters = np.array([[1.0, 1.0, 1.0], [1.62, 9.81, 3.7], [1.0, 1.0, 1.0]])
    assert (failing(pendulum(), parameters).status == Status.DONE).all()
    lossy = failing(pendulum(damping=0.01), parameters)
    assert lossy.status.tolist() == [Status.DONE, Status.ENERGY, Status.DONE]
    assert (failing(pendulum(damping=0.01), parameters, energy_limit=0.1).status == Status.DONE).all()


def test_too_many_steps_end_a_sample():
    outcome = failing(oscillator(), W, most_steps=12)
    few = outcome.status == Status.DONE
    assert set(outcome.status) == {Status.DONE, Status.TOO_MANY_STEPS}
    assert W[few].max() < W[~few].min()  # the fast ones


def test_every_status_says_what_it_is():
    assert len({one.words for one in Status}) == len(Status)


@pytest.mark.parametrize(
    "one", [Reduction("at", 0, -1.0), Reduction("at", 0, T + 1.0), Reduction("most", 0), Reduction("max", 7)]
)
def test_reductions_that_the_run_does_not_have_are_refused(one):
    with pytest.raises(ValueError, match="expected"):
        Program(oscillator(), lowered, DOP853, [one], T)
