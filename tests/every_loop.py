"""Short runs that go through every loop of the package, and numbers that they lead to."""

import numpy as np

import rattle as rt


def compliant():
    """The adaptive steps of dop853 with compliant contacts, from contact to contact."""
    r = rt.example("fourbar").simulate(0.03, horizon=False)
    return [r.t[-1], *(r[name][-1] for name in ("crank.angle", "rocker.omega", "O3.normal", "energy.kinetic"))]


def implicit_steps():
    """Steps of radau, with its Jacobian and matrices, into contacts and out of them."""
    r = rt.example("slider_crank_play").simulate(2e-4, method="radau", horizon=False)
    return [r.t[-1], *(r[name][-1] for name in ("crank.angle", "rod.omega", "B.normal", "energy.kinetic"))]


def fixed_steps():
    """Steps of rk4 and rows of ideal joints, of loads and of a motor."""
    r = rt.example("squeezer").simulate(2e-3, method="rk4", step=2e-5, horizon=False)
    return [float(r[name][-1]) for name in r.names if name.endswith((".angle", ".omega", ".fx"))]


def events():
    """Impacts, forces of lasting contacts and the search for events."""
    r = rt.example("bouncing_pin").simulate(0.12, method="event", horizon=False)
    return [float(len(r.events)), *(r[name][-1] for name in r.names if name.endswith((".x", ".y", ".vx", ".vy")))]


def fixed_impacts():
    """The time steps of Moreau and Jean."""
    r = rt.example("bouncing_pin").simulate(0.4, method="moreau", step=1e-3, horizon=False)
    return [r[name][-1] for name in r.names if name.endswith((".x", ".y", ".vx", ".vy"))]


MIXED = ("crank.angle", "coupler.omega", "rocker.omega", "O2.ex", "O2.ey", "O3.ex", "O3.ey", "energy.kinetic")


def events_in_oil():
    """Implicit steps from event to event, with an oil film beside impacts."""
    r = rt.example("fourbar_oil").simulate(1.5e-3, rtol=1e-6, horizon=False)
    return [float(len(r.events)), *(r[name][-1] for name in MIXED)]


def impacts_in_oil():
    """Time steps with a film at their ends."""
    r = rt.example("fourbar_oil").simulate(2e-3, method="moreau", step=1e-4, horizon=False)
    return [float(len(r.events)), *(r[name][-1] for name in MIXED)]


def positions():
    """The sweep over positions, with all reactions."""
    r = rt.example("slider_crank").inverse_dynamics(np.linspace(0.0, 0.02, 21))
    return [float(r[name][-1]) for name in r.names if name.endswith((".angle", ".omega", ".alpha", ".fx", ".fy"))]


def equilibria():
    """The search for equilibria."""
    found = rt.example("balanced_arm").equilibrium()
    return [float(len(found)), *(float(number) for one in found for number in one.q)]


LOOPS = (
    compliant,
    implicit_steps,
    fixed_steps,
    events,
    fixed_impacts,
    events_in_oil,
    impacts_in_oil,
    positions,
    equilibria,
)


def numbers():
    """All of them by name of the loop."""
    return {one.__name__: [float(number) for number in one()] for one in LOOPS}
