"""The guide about bars that make up for play keeps its word; another formulation gives its curves and its design."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from test_pages import BLOCK, DOCS, shows

pytestmark = pytest.mark.long  # the program of the page searches designs for a minute

BARS = ("frame", "arm", "link", "swing", "px", "py")
BLOCKS = BLOCK.findall(DOCS["play-and-path.md"])
G = 9.81


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The folder in which the program of the page ran, and what it printed."""
    folder = tmp_path_factory.mktemp("page")
    code = "\n".join(text for language, text in BLOCKS if language == "python")
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=folder, timeout=600, text=True, stdout=subprocess.PIPE
    )
    return folder, done.stdout


def test_the_guide_prints_what_it_shows(page):
    folder, said = page
    lines = [line for language, text in BLOCKS if language == "text" for line in text.splitlines()]
    assert len(lines) > 25
    for line in lines:
        assert shows(said, line, 2e-3), f"{line}\n{said}"  # half a unit of the last digit of 0.627
    assert (folder / "play-and-path.png").stat().st_size > 10_000


# ---------------------------------------------------------------- another formulation
def unit(angle):
    return np.exp(1j * angle)


class TwoLinks:
    """Crank-rockers with two massless links in complex numbers; the directions a and b of the links are coordinates.

    Parameters may be arrays: so many designs move at once.

    Loop: link u(gamma) - swing u(psi) = D = frame - arm u(theta) - c u(a) - c u(b), a triangle for gamma and psi.
    Rates follow from link gamma' u(gamma) - swing psi' u(psi) = D'/i, accelerations likewise.  Equations of motion:
    the power of m r'' - f vanishes for every rate of a and b (d'Alembert, Jourdain).
    """

    def __init__(self, **given):
        self.p = given
        self.omega = 2.0 * np.pi / given["T"]
        self.center = (given["link"] + given["px"] + 1j * given["py"]) / 3.0
        self.torque = -3.0

    def angles(self, t, a, b):
        p = self.p
        gap = p["frame"] - p["arm"] * unit(self.omega * t) - p["c"] * (unit(a) + unit(b))
        cosine = (p["link"] ** 2 + abs(gap) ** 2 - p["swing"] ** 2) / (2.0 * p["link"] * abs(gap))
        gamma = np.angle(gap) + np.arccos(cosine)
        return gamma, np.angle(p["link"] * unit(gamma) - gap)

    def tracing_point(self, t, a, b):
        p, (gamma, _) = self.p, self.angles(t, a, b)
        return p["arm"] * unit(self.omega * t) + p["c"] * unit(a) + (p["px"] + 1j * p["py"]) * unit(gamma)

    def rate(self, t, y):
        a, b, da, db = y.reshape(4, -1)
        p, w, (gamma, psi) = self.p, self.omega, self.angles(t, a, b)
        ua, ub, ug, up, ut = (unit(one) for one in (a, b, gamma, psi, w * t))

        def turns(x):
            """Rates (or accelerations) of coupler and rocker with link*gamma'*u(gamma) - swing*psi'*u(psi) = x."""
            sine = np.sin(gamma - psi)
            return (x * up.conjugate()).imag / (p["link"] * sine), (x * ug.conjugate()).imag / (p["swing"] * sine)

        dg, dp = turns(-(p["arm"] * w * ut + p["c"] * (da * ua + db * ub)))
        by_a, by_b = turns(-p["c"] * ua), turns(-p["c"] * ub)
        virtual = (
            (1j * p["c"] * ua + 1j * self.center * ug * by_a[0], *by_a),
            (1j * self.center * ug * by_b[0], *by_b),
        )

        def left(dda, ddb):
            """Power that is left for unit rates of a and b, at accelerations of a and b."""
            pins = p["c"] * ((1j * dda - da**2) * ua + (1j * ddb - db**2) * ub)
            bend = p["arm"] * w**2 * ut - pins + p["link"] * dg**2 * ug - p["swing"] * dp**2 * up
            ddg, ddp = turns(bend / 1j)
            r = -p["arm"] * w**2 * ut + p["c"] * (1j * dda - da**2) * ua + self.center * (1j * ddg - dg**2) * ug
            force, couple = 0.3 * (r + 1j * G), 1e-3 * ddg
            moment = 0.2 * p["swing"] ** 2 / 3.0 * ddp - self.torque + 0.2 * G * p["swing"] / 2.0 * np.cos(psi)
            return np.array([(force * v.conjugate()).real + couple * vg + moment * vp for v, vg, vp in virtual])

        free = left(0.0, 0.0)
        matrix = np.array([left(1.0, 0.0) - free, left(0.0, 1.0) - free])  # symmetric
        return np.concatenate([da, db, *np.linalg.solve(matrix.T, -free.T[:, :, None])[:, :, 0].T])

    def path(self, times):
        """Tracing points x + iy [m], (designs, times), at times [s], from rest of the pins in their bushes."""
        count = max(np.size(one) for one in self.p.values())
        start = np.concatenate([np.full(count, one) for one in (self.p["phi_A"], self.p["phi_B"], 0.0, 0.0)])
        found = solve_ivp(self.rate, (0.0, times[-1]), start, "DOP853", times, rtol=1e-11, atol=1e-11).y
        y = found.reshape(4, count, -1)
        return np.transpose([self.tracing_point(t, y[0, :, n], y[1, :, n]) for n, t in enumerate(times)])


def given(m):
    return {name: m.parameters[name] for name in (*BARS, "c", "phi_A", "phi_B", "T")}


def goal(times):
    """The path of the mechanism as drawn without play."""
    return TwoLinks(**given(rt.example("crank_rocker_play")) | {"c": 0.0}).tracing_point(times, 0.0, 0.0)


def test_another_formulation_gives_the_deviations_of_the_guide(page):
    folder, said = page
    times = np.linspace(0.0, 0.3, 1000, endpoint=False)
    designs = {"as drawn": rt.example("crank_rocker_play"), "found": rt.load(folder / "best.toml")}
    both = [given(m) for m in designs.values()]
    paths = TwoLinks(**{k: np.array([one[k] for one in both]) for k in both[0]}).path(times)
    for (name, m), path in zip(designs.items(), paths, strict=True):
        r = m.simulate(times[-1], t_eval=times)
        np.testing.assert_allclose(r["coupler.P.x"] + 1j * r["coupler.P.y"], path, rtol=0.0, atol=1e-9)
        off = 1e3 * abs(path - goal(times))
        assert shows(said, f"{name}: {off.max():.3f} mm at most, {np.sqrt(np.mean(off**2)):.3f} mm rms", 2e-3)


def test_no_step_of_another_formulation_leads_to_a_better_design(page):
    """Gauss-Newton's step there is far below what could be made, and what it would gain below what can be seen."""
    best, times, h = given(rt.load(page[0] / "best.toml")), 0.3 * np.arange(16) / 16, 1e-6  # m
    beside = {name: best[name] + h * np.array([0.0, *(name == one for one in BARS)]) for name in BARS}
    off = TwoLinks(**best | beside).path(times) - goal(times)
    here, *moved = np.hstack([off.real, off.imag])
    slopes = (np.array(moved) - here) / h
    step = np.linalg.lstsq(slopes.T, -here, rcond=None)[0]
    assert abs(step).max() < 1e-6
    assert np.sum((here + step @ slopes) ** 2) == pytest.approx(np.sum(here**2), rel=1e-4)
    assert np.sum(here**2) == pytest.approx(9.850e-9, rel=2e-3)  # m^2; the goals of the guide are rounded to 0.1 um
