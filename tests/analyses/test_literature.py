"""Numbers from the literature and from independent computations; those of one number each stand in `published`.

"Independent" means: computed by two other routes that agree to more digits than are given here, not printed in a paper.
"""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

import published
import rattle as rt

DATA = Path(__file__).parents[1] / "data"
RECORDED = {"fourbar_M+40_g0.csv": (40.0, 0.0), "fourbar_M-40_g9.81.csv": (-40.0, 9.81)}


def fourbar(M: float = 40.0, g: float = 0.0, **more) -> rt.Mechanism:
    return rt.example("fourbar").set({"M": M, "gravity": [0, -g], **more})


# ---------------------------------------------------------------- the list that the documentation shows as well
@pytest.mark.parametrize("case", published.CASES, ids=str)
def test_a_published_number_is_met_within_its_tolerance(case):
    assert case.measure() == pytest.approx(case.expected, rel=0.0, abs=case.tolerance)


@pytest.mark.nojit
def test_every_published_number_says_where_it_comes_from():
    assert all(case.source and case.kind in ("published", "closed form", "independent") for case in published.CASES)
    assert len({str(case) for case in published.CASES}) == len(published.CASES)


# ---------------------------------------------------------------- the paper's four-bar with play
@pytest.mark.parametrize("file", RECORDED)
def test_paper_with_play_every_half_millisecond(file):
    want = np.genfromtxt(DATA / file, delimiter=",", comments="#", names=True, skip_header=3)
    r = fourbar(*RECORDED[file]).simulate(0.05, t_eval=want["t"], rtol=1e-11, atol=1e-13)
    motion = {
        f"{body}.{key}": column + number
        for body, number in (("coupler", "2"), ("rocker", "3"))
        for key, column in zip(
            ("x", "y", "angle", "vx", "vy", "omega"), ("X", "Y", "theta", "vX", "vY", "omega"), strict=True
        )
    }
    for name, column in motion.items():
        assert np.abs(r[name] - want[column]).max() < (1e-8 if column[0] in "XYt" else 1e-6)
    forces = {"H2": -r["O2.fx"], "V2": -r["O2.fy"], "N3": r["O3.normal"], "N4": r["O4.normal"]}
    for column, got in forces.items():
        assert np.abs(got - want[column]).max() < 1e-5 * np.abs(want[column]).max()


def test_paper_by_its_own_method():
    r = fourbar().simulate(0.05, t_eval=[0.05], method="rk4", step=0.05 / 8000)
    assert r["rocker.angle"][0] == pytest.approx(-1.1619901719, abs=1e-8)  # independent


def test_smaller_play_brings_the_ideal_motion_but_with_the_papers_rates_larger_forces():
    """Positions converge as O(r) to the mechanism of r = 0, reactions grow as 1/r: its rates are others."""
    times = np.linspace(0, 0.1, 2001)
    limit = fourbar(**{"parameters.r3": 0, "parameters.r4": 0}).ideal().simulate(t_eval=times)
    slope, peak = [], []
    for r in (5e-3, 5e-4, 5e-5):
        run = fourbar(**{"parameters.r3": r, "parameters.r4": r}).simulate(t_eval=times)
        slope.append(np.abs(run["coupler.angle"] - limit["coupler.angle"]).max() / r)
        peak.append(max(np.abs(run["O3.normal"]).max(), np.abs(run["O4.normal"]).max()))
    # independent: 4.8 to 5.6 rad per metre of play; the smallest is chaotic: 5.54 to 5.67 at rtol 1e-10 to 1e-8
    assert all(4.8 < one < 6.0 for one in slope)
    assert all(5 < after / before < 15 for before, after in itertools.pairwise(peak))  # independent: 9 to 15


def test_rates_that_fit_the_ideal_mechanism_keep_the_forces_bounded():
    text = rt.example("fourbar").to_toml()
    assert text.count(", omega = 0 }") == 2
    text = text.replace(", omega = 0 }", " }")
    times = np.linspace(0, 0.1, 2001)
    peak = []
    for r in (5e-3, 5e-4, 5e-5):
        run = rt.loads(text).set({"parameters.r3": r, "parameters.r4": r}).simulate(t_eval=times)
        peak.append(max(np.abs(run["O3.normal"]).max(), np.abs(run["O4.normal"]).max()))
    assert max(peak) < 1.1 * min(peak)  # as they would grow a hundredfold with the paper's rates


# ---------------------------------------------------------------- the paper's four-bar without play
IDEAL = [  # t; theta2, theta3, their rates; force on coupler at O2, on rocker at O3 and O4; torque on the crank
    (0.0, 1.03754802, -1.03754802, -3.27868852, -3.27868852,
     6.77044468, 35.24026882, 36.77044468, 48.63291030, -46.77044468, -62.02555178, 7.04805376),
    (0.1, 0.69007084, -1.16069930, -2.88220764, 1.05782617,
     7.80419710, 3.85358399, 41.09716334, 31.19121698, -63.58408347, -41.69943028, -0.89698102),
    (0.3, 0.54491564, -0.60090110, 1.62204680, 2.31909089,
     99.29214940, 51.37132085, 69.03593871, 44.64666092, -58.57957794, -35.09960082, -12.97386622),
]  # fmt: skip


@pytest.mark.parametrize("row", IDEAL)
def test_paper_without_play(row):
    t = row[0]
    r = fourbar().ideal().simulate(0.3, t_eval=sorted({t, 0.3}))
    names = ("coupler.angle", "rocker.angle", "coupler.omega", "rocker.omega", "O2.fx", "O2.fy", "O3.fx", "O3.fy")
    got = [r[name][0] for name in names] + [-r["O4.fx"][0], -r["O4.fy"][0], r["motor.torque"][0]]
    assert got == pytest.approx(row[1:], abs=2e-7)  # independent, 8 decimals; O4 connects rocker to ground


STATICS = [  # M, g, theta2, theta3, N3, N4: crank held at 0 deg
    (-40.0, 0.0, 1.028319194262, -1.056636729664, 76.5661893152, 76.5661893152),
    (40.0, 9.81, 1.044081187923, -1.018844189722, 78.9900595625, 63.6192904624),
]


@pytest.mark.parametrize(("M", "g", "theta2", "theta3", "N3", "N4"), STATICS)
def test_paper_at_rest_stays_at_rest(M, g, theta2, theta3, N3, N4):
    gap = np.array([0.81 - 0.2, 0.0])
    for angle in (theta2, theta3):
        gap -= 0.6 * np.array([math.cos(angle), math.sin(angle)])
    across = math.sqrt(max(0.0, 0.005**2 - gap @ gap / 4)) / np.hypot(*gap) * np.array([-gap[1], gap[0]])
    least = []
    for side in (1, -1):  # two massless links of 5 mm close the gap in two ways
        offsets = {
            "initial.O3.offset": list(gap / 2 + side * across),
            "initial.O4.offset": list(gap / 2 - side * across),
        }
        angles = {"initial.coupler.angle": theta2, "initial.rocker.angle": theta3}
        m = fourbar(M, g).set({"drivers.motor.angle": 0, **angles, **offsets})
        r = m.simulate(1e-3, t_eval=[0.0])
        off = r["coupler.alpha"][0], r["rocker.alpha"][0], r["O3.normal"][0] - N3, r["O4.normal"][0] - N4
        least.append(np.abs(off).max())
    # independent; where both links lie in one line (first case) their direction goes with the root of the last digit
    assert min(least) < 1e-3


# ---------------------------------------------------------------- closed forms with play
def test_rod_hanging_in_its_clearance_has_two_frequencies():
    """Bar of 1 m, 1 kg on a pin with 5 mm play: a double pendulum whose upper link is massless and 5 mm long.

    Small swings: det(K - w^2 M) = 0 with M = [[c^2, c/2], [c/2, 1/3]], K = g diag(c, 1/2).
    """
    c, g = 0.005, 9.81
    M, K = np.array([[c * c, c / 2], [c / 2, 1 / 3]]), g * np.diag([c, 0.5])
    frequencies = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real))
    assert frequencies == pytest.approx([3.8252500863, 88.8382094697], abs=1e-9)
    m = rt.Mechanism("hanging rod", gravity=[0, -g]).ground(O=[0, 0])
    m.bar("rod", "T", "B", length=1, mass=1).revolute("O", "ground.O", "rod.T", clearance=c, contact="massless-link")
    m.initial("rod", angle="-pi/2 + 1e-4", omega=0, vx=0, vy=0).initial("O", offset=[0, -c])
    r = m.simulate(t_eval=np.linspace(0, 3, 6001), rtol=1e-11, atol=1e-13)
    swing = r["rod.angle"] + math.pi / 2
    basis = np.array([f(w * r.t) for w in frequencies for f in (np.cos, np.sin)]).T
    rest = swing - basis @ np.linalg.lstsq(basis, swing, rcond=None)[0]
    assert np.abs(rest).max() < 1e-4 * np.abs(swing).max()  # terms of third order: swings of 1e-4 to 1e-2 rad
