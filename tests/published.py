"""Numbers from papers, test sets, closed forms and independent programs, and how the same is measured here.

One list for two readers: the tests hold every case to its tolerance, the documentation shows what was measured.
"Independent" means: computed by two other routes that agree to more digits than are given here, not printed anywhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

import rattle as rt
from rattle.results.event import Event
from rattle.results.result import Result

PUBLISHED, CLOSED, INDEPENDENT = "published", "closed form", "independent"


@dataclass(frozen=True)
class Case:
    """One number: where it comes from, and how far the same number computed here may be from it."""

    group: str
    what: str
    kind: str  # published | closed form | independent
    source: str
    unit: str
    expected: float
    tolerance: float  # largest error allowed, in the same unit
    measure: Callable[[], float]

    def __str__(self) -> str:
        return f"{self.group}: {self.what}"


def fourbar(M: float = 40.0, g: float = 0.0) -> rt.Mechanism:
    """The paper's four-bar with a moment [N m] on its rocker under gravity [m/s^2]."""
    return rt.example("fourbar").set({"M": M, "gravity": [0, -g]})


# ---------------------------------------------------------------- the paper's four-bar with play
GRIGORE = "mechanism of Grigore, Jderu, Enachescu (2015), which prints no numbers"
AT_START = (
    (40.0, 0.0, (-16.913254230, 191.806895396, 275.306033837, -212.474678096)),
    (-40.0, 9.81, (-33.585603676, 229.388964361, 357.710574138, -30.993248049)),
)
IN_MOTION = (  # M, g, t, theta2, theta3, N3, N4
    (40.0, 0.0, 0.005, 1.0307401612, -1.0407871273, 322.706047, 2130.174548),
    (40.0, 0.0, 0.01, 0.9981069675, -1.0561451595, -7.737325, 283.472450),
    (40.0, 0.0, 0.02, 0.9681015169, -1.1060245622, 536.513259, -465.196154),
    (40.0, 0.0, 0.05, 0.8548610709, -1.1619901719, 1001.535724, -438.613590),
    (-40.0, 9.81, 0.01, 1.0036556626, -1.0609561907, 240.678810, -242.434481),
    (-40.0, 9.81, 0.02, 0.9675284466, -1.0991694565, -1044.853118, 4553.218412),
    (-40.0, 9.81, 0.05, 0.8709952725, -1.1403974629, -93.116032, 95.882243),
)


@cache
def fourbar_at(M: float, g: float, t: float) -> Result:
    """One instant of the paper's motion; the start needs no more than its first force."""
    if t == 0.0:
        return fourbar(M, g).simulate(1e-3, t_eval=[0.0])
    return fourbar(M, g).simulate(t, t_eval=[t], rtol=1e-12, atol=1e-14)


def with_play() -> Iterator[Case]:
    """Motion and reactions of the paper's four-bar with two massless links."""
    group = "Four-bar of the paper, two pins with play"
    for M, g, values in AT_START:
        names = (("H2", "O2.fx", -1), ("V2", "O2.fy", -1), ("N3", "O3.normal", 1), ("N4", "O4.normal", 1))
        for (symbol, name, sign), value in zip(names, values, strict=True):
            what = f"{symbol} at the start, M = {M:g} N m, g = {g:g} m/s²"

            def measure(M: float = M, g: float = g, name: str = name, sign: int = sign) -> float:
                return sign * float(fourbar_at(M, g, 0.0)[name][0])

            yield Case(group, what, INDEPENDENT, GRIGORE, "N", value, 2e-9, measure)  # given to 9 decimals
    for M, g, t, *values in IN_MOTION:
        names = (("θ2", "coupler.angle"), ("θ3", "rocker.angle"), ("N3", "O3.normal"), ("N4", "O4.normal"))
        for (symbol, name), value in zip(names, values, strict=True):
            angle = name.endswith("angle")
            allowed = 1e-8 if angle else max(1e-5 * abs(value), 2e-3)  # forces reach 5e3 N: 1e-5 of a range
            what = f"{symbol} at {1e3 * t:g} ms, M = {M:g} N m, g = {g:g} m/s²"

            def measure(M: float = M, g: float = g, t: float = t, name: str = name) -> float:
                return float(fourbar_at(M, g, t)[name][0])

            yield Case(group, what, INDEPENDENT, GRIGORE, "rad" if angle else "N", value, allowed, measure)


# ---------------------------------------------------------------- ideal mechanisms
SQUEEZER = (
    ("beta", 15.81077119629904, {"k1": 1}),
    ("Theta", -15.75637105984298, {"k2": 1, "k1": -1}),
    ("gamma", 0.04082224013073101, {"k3": 1}),
    ("Phi", -0.5347301163226948, {"k4": 1, "k5": -1}),
    ("delta", 0.5244099658805304, {"k5": 1}),
    ("Omega", 0.5347301163226948, {"k6": 1, "k7": -1}),
    ("epsilon", 1.048080741042263, {"k7": 1}),
)


@cache
def squeezer() -> Result:
    """Andrews' squeezing mechanism at 30 ms."""
    return rt.example("squeezer").simulate(t_eval=[0.03])


@cache
def point_pendulum() -> Result:
    """IFToMM A01 after 10 s."""
    m = rt.Mechanism("A01", gravity=[0, -9.81]).ground(O=[0, 0])
    m.body("bob", mass=1, inertia=1, points={"P": [0, 0]}).rod("string", "ground.O", "bob.P", length=1)
    m.initial("bob", x=-1, y=0, angle=0, vx=0, vy=0, omega=0)
    return m.simulate(10, t_eval=[10.0], rtol=1e-12, atol=1e-13)


@cache
def windows() -> Result:
    """IFToMM A02 over its 10 s."""
    return rt.example("windows").simulate()


@cache
def slider_crank() -> Result:
    """Two turns of the slider-crank with ideal pins."""
    return rt.example("slider_crank").simulate()


def without_play() -> Iterator[Case]:
    """Mechanisms with ideal joints."""
    source = 'IVP test set (Mazzia, Magherini 2008), problem "Andrews\' squeezing mechanism"'
    for symbol, value, made_of in SQUEEZER:

        def measure(made_of: dict[str, int] = made_of) -> float:
            return float(sum(sign * squeezer()[f"{body}.angle"][0] for body, sign in made_of.items()))

        yield Case("Squeezing mechanism", f"{symbol} at 30 ms", PUBLISHED, source, "rad", value, 1e-7, measure)
    library = "IFToMM library of benchmark problems"
    for axis, value in (("x", -0.275087462576117), ("y", -0.961419205099125)):
        yield Case(
            "Point pendulum (A01)", f"{axis} at 10 s", INDEPENDENT, f"{library}, A01", "m", value, 1e-8,
            lambda axis=axis: float(point_pendulum()[f"bob.{axis}"][0]),
        )  # fmt: skip
    for axis, value in (("x", 0.3284581115), ("y", 0.9445185382)):
        yield Case(
            "Two windows (A02)", f"{axis} of the first corner at 10 s", INDEPENDENT,
            f"{library}, A02; Exudyn agrees to 1e-6", "m", value, 1e-6,
            lambda axis=axis: float(windows()[f"p0.P.{axis}"][-1]),
        )  # fmt: skip
    yield Case(
        "Slider-crank", "largest torque of the motor", INDEPENDENT, "dimensions of Flores, Ambrosio (2004)", "N m",
        138.521666438, 1e-6,  # found within steps; independent: the slope of the kinetic energy over the angle
        lambda: slider_crank().peak("motor.torque")[0],
    )  # fmt: skip
    a, rod, w = 0.05, 0.12, 5000 * math.pi / 30
    yield Case(
        "Slider-crank", "acceleration of the slider at the outer dead centre", CLOSED, "a ω² (1 + a/l)", "m/s²",
        -a * w * w * (1 + a / rod), 1e-6, lambda: float(slider_crank()["slider.ax"][0]),
    )  # fmt: skip
    b = math.asin(0.5)
    yield Case(
        "Quick return", "time forth over time back", CLOSED, "(π + 2b)/(π - 2b), sin b = r/d", "",
        (math.pi + 2 * b) / (math.pi - 2 * b), 1e-6, time_ratio,
    )  # fmt: skip


def time_ratio() -> float:
    """Time forth over time back of the crank-shaper, from the instants at which its ram turns around."""
    r = rt.example("quick_return").simulate(2.2, t_eval=np.linspace(0.0, 2.2, 22001))
    v = r["ram.vx"]
    turns = np.flatnonzero(v[:-1] * v[1:] < 0)
    at = r.t[turns] - v[turns] * (r.t[turns + 1] - r.t[turns]) / (v[turns + 1] - v[turns])
    spans = np.diff(at)
    return float(max(spans[0], spans[1]) / min(spans[0], spans[1]))


# ---------------------------------------------------------------- rest
def clamp_advantage(t: float) -> float:
    """Force at the jaw of the hand-closed clamp per moment at its arm."""
    return float(rt.example("toggle_clamp").equilibrium([0.0, t])["work.advantage"][-1])


@cache
def hanging_rod() -> np.ndarray:
    """Circular frequencies of a bar of 1 m and 1 kg on a pin with 5 mm of play."""
    m = rt.Mechanism("hanging rod", gravity=[0, -9.81]).ground(O=[0, 0])
    m.bar("rod", "T", "B", length=1, mass=1).revolute(
        "O", "ground.O", "rod.T", clearance=0.005, contact="massless-link"
    )
    return np.asarray(m.initial("rod", angle="-pi/2").modes().omega)


def at_rest() -> Iterator[Case]:
    """Equilibrium, quasi-static motion and small vibrations."""
    for degrees in (40, 1):
        angle = math.radians(degrees)
        yield Case(
            "Toggle clamp", f"advantage at {degrees}°", CLOSED, "1/(2 l sin θ)", "1/m", 1 / (0.2 * math.sin(angle)),
            1e-9 / (0.2 * math.sin(angle)), lambda t=(40 - degrees) / 39: clamp_advantage(t) if t else clamp_start(),
        )  # fmt: skip
    c, g = 0.005, 9.81
    mass, stiffness = np.array([[c * c, c / 2], [c / 2, 1 / 3]]), g * np.diag([c, 0.5])
    for n, value in enumerate(np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real))):
        yield Case(
            "Rod hanging in its play", f"circular frequency {n + 1}", CLOSED, "det(K - ω² M) = 0, mobility 2",
            "rad/s", float(value), 1e-9 * float(value), lambda n=n: float(hanging_rod()[n]),
        )  # fmt: skip


def clamp_start() -> float:
    """The same before anything has moved."""
    return float(rt.example("toggle_clamp").equilibrium([0.0, 0.5])["work.advantage"][0])


# ---------------------------------------------------------------- elastic contact
HITS = (  # time, approach speed, peak force of the contacts of the slider-crank with play
    (2.27286032e-4, 4.3857831, 45872.27),
    (6.3705643e-4, 2.756949, 20869.93),
    (7.4970028e-4, 1.826699, 25926.15),
    (1.0859470e-3, 1.101851, 6557.87),
    (1.2058161e-3, 0.823801, 12915.66),
    (1.551486e-3, 0.270939, 1672.21),
)


@cache
def hits() -> list[Event]:
    """First contacts of the slider-crank with play."""
    r = rt.example("slider_crank_play").simulate(1.8e-3, rtol=1e-10, atol=1e-13)
    return [one for one in r.events if one.kind == "contact"]


@cache
def thrown_pin(law: str, e: float = 0.5) -> Result:
    """A pin of 1 kg thrown at 0.5 m/s against the wall of its bush, 1 mm away."""
    contact = {"model": law, "restitution": e, "stiffness": 1e9, "exponent": 1.5}
    m = rt.Mechanism("thrown pin").ground(O=[0, 0]).body("pin", mass=1, inertia=1e-3, points={"P": [0, 0]})
    m.revolute("O", "ground.O", "pin.P", clearance=1e-3, contact=contact)
    m.initial("pin", x=0, y=0, angle=0, vx=0.5, vy=0, omega=0)
    return m.simulate(0.0035, rtol=1e-11, atol=1e-14)


def thrown_contact(law: str) -> Event:
    """Its only contact."""
    (one,) = [one for one in thrown_pin(law).events if one.kind == "contact"]
    return one


def elastic() -> Iterator[Case]:
    """Contacts by force laws."""
    group, source = "Slider-crank with play, elastic contact", "data as in Flores, Ambrosio (2004)"
    for n, (t, v0, peak) in enumerate(HITS):
        yield Case(group, f"start of contact {n + 1}", INDEPENDENT, source, "s", t, 1e-6 * t, lambda n=n: hits()[n].t)
        yield Case(
            group, f"approach speed of contact {n + 1}", INDEPENDENT, source, "m/s", v0, 1e-5 * v0,
            lambda n=n: hits()[n].normal_speed,
        )  # fmt: skip
        yield Case(
            group, f"peak force of contact {n + 1}", INDEPENDENT, source, "N", peak, 2e-4 * peak,
            lambda n=n: hits()[n].peak_force,
        )  # fmt: skip
    K, v = 1e9, 0.5
    deep = 1.09336207394 * (v * v / K) ** 0.4  # (5/4)^(2/5) (m v^2/K)^(2/5)
    yield Case(
        "Hertz impact", "duration", CLOSED, "2.9433 δ/v (Hertz 1882)", "s", 2.94327518432 * deep / v,
        2.94327518432e-8 * deep / v, lambda: thrown_contact("hertz").duration,
    )  # fmt: skip
    yield Case(
        "Hertz impact", "peak force", CLOSED, "K δ^1.5", "N", K * deep**1.5, 1e-6 * K * deep**1.5,
        lambda: thrown_contact("hertz").peak_force,
    )  # fmt: skip
    for law, e, value in (("exact", 0.3, 0.3), ("exact", 0.9, 0.9)):
        yield Case(
            "Restitution of a free impact", f"law `{law}`, e = {e:g} asked for", CLOSED,
            "ln((1+a)/(1-xa)) = a(1+x)", "", value, 2e-8,
            lambda law=law, e=e: abs(float(thrown_pin(law, e)["pin.vx"][-1])) / 0.5,
        )  # fmt: skip


# ---------------------------------------------------------------- impacts
@cache
def bouncing_pin() -> Result:
    """A pin that bounces in its bush, without friction."""
    return rt.example("bouncing_pin").simulate(0.02, rtol=1e-11, atol=1e-13)


@cache
def guide() -> Result:
    """The slider-crank with play in its guide."""
    return rt.example("guide_play").simulate(0.2, t_eval=[0.0, 0.01, 0.05, 0.1, 0.2], rtol=1e-10, atol=1e-12)


@cache
def woodpecker() -> tuple[float, float]:
    """Time and way down of a beat of the woodpecker, means over those that have settled."""
    r = rt.example("woodpecker").simulate(2.0)
    knocks = np.unique([round(one.t, 13) for one in r.events if one.kind == "impact" and one.joint == "beak"])
    down = np.diff(np.interp(knocks, r.t, r["sleeve.y"]))
    return float(np.diff(knocks)[6:].mean()), float(-down[6:].mean())


def lost_in_impacts(r: Result) -> float:
    """Energy lost in all impacts of a run [J]."""
    return float(sum(one.energy_lost for one in r.events if one.kind == "impact"))


def impacts() -> Iterator[Case]:
    """Set-valued contact: impacts, sequences of bounces, lasting contact."""
    group = "Pin bouncing in its bush"
    for n, value in enumerate((1.553954329, 3.054303658, 4.437756907)):
        yield Case(
            group, f"time from the first to impact {n + 2}", CLOSED, "chords of a circle, 2 c u_n/|u|² each", "ms",
            value, 1e-8, lambda n=n: 1e3 * (sorted_times(bouncing_pin())[n + 1] - sorted_times(bouncing_pin())[0]),
        )  # fmt: skip
    yield Case(
        group, "end of the infinite sequence", CLOSED, "sum of all chords", "ms", 11.397165651, 1e-6,
        lambda: 1e3 * (next(one.t for one in bouncing_pin().events if one.kind == "contact") - 0.5e-3),
    )  # fmt: skip
    yield Case(
        group, "energy lost", CLOSED, "the whole normal motion, (cos 40°)²/2", "J",
        0.5 * math.cos(math.radians(40)) ** 2, 1e-9, lambda: lost_in_impacts(bouncing_pin()),
    )  # fmt: skip
    group, source = "Slider-crank with play in its guide", "Flores, Leine, Glocker (2010) for the mechanism"
    for n, (t, value) in enumerate(
        zip((10, 50, 100, 200), (0.1508727302, 0.7629178618, 1.4324963219, 2.8781068468), strict=True)
    ):
        yield Case(
            group, f"turns of the crank at {t} ms", INDEPENDENT, source, "", value, 1e-8,
            lambda n=n: float(guide()["crank.angle"][n + 1]) / (2 * math.pi),
        )  # fmt: skip
    yield Case(
        group, "energy lost in impacts", INDEPENDENT, source, "J", 0.4823502, 3e-7, lambda: lost_in_impacts(guide())
    )
    source = "Glocker (1995), section 8.2"
    yield Case("Woodpecker toy", "time of a beat", PUBLISHED, source, "s", 0.1460, 2e-4, lambda: woodpecker()[0])
    yield Case("Woodpecker toy", "way down in a beat", PUBLISHED, source, "m", 0.0194, 1e-4, lambda: woodpecker()[1])


def sorted_times(r: Result) -> list[float]:
    """Instants of all impacts."""
    return sorted(one.t for one in r.events if one.kind == "impact")


CASES = (*with_play(), *without_play(), *at_rest(), *elastic(), *impacts())
