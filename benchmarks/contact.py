"""Contacts: the slider-crank with play in compiled run time, and a pin in its bush against Exudyn at equal error.

Exudyn's side is set up in its favour: fast build without range checks, the same elastic contact (stiffness times
penetration to the power 1.5, nothing lost, so that both solve the same equations), no output files, explicit solver
(Runge-Kutta 4; generalised-alpha needs more than ten times the steps), the fewest steps that meet the error.  Of
both programs the solver alone is timed, not what sets it up; the whole call of rattle stands below.

Source of the contact object: Exudyn 1.13, ObjectContactSphereSphere with isHollowSphere1.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

import numpy as np

import rattle as rt
from measure import Row, interleave, timed

C, BORE, STIFFNESS, SPEED, TILT = 5e-4, 0.01, 6.6101983979e10, 1.0, math.radians(40)
END = 0.05  # [s], some fifty contacts
ALLOWED = 1e-8  # [m]

Solve = Callable[[], np.ndarray]  # position of the pin at END

LAST: dict[str, float] = {}  # stats of rattle's last run

PIN = f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.pin]
points = {{ P = [0, 0] }}
mass = 0.14
inertia = 1e-4
[joints.O]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = {C}
contact = {{ model = "hertz", stiffness = {STIFFNESS}, exponent = 1.5, bush_radius = {BORE} }}
[initial]
pin = {{ x = 0, y = 1e-4, angle = 0, vx = {SPEED * math.cos(TILT)}, vy = {SPEED * math.sin(TILT)}, omega = 0 }}
"""


def rattle_pin(rtol: float) -> Solve:
    """rattle's pin in its bush at a tolerance."""
    mechanism = rt.loads(PIN)

    def solve() -> np.ndarray:
        r = mechanism.simulate(END, t_eval=[0.0, END], rtol=rtol)
        LAST.update(r.stats)
        return np.array([r["pin.x"][-1], r["pin.y"][-1]])

    return solve


def exudyn_pin(steps: float) -> Solve:
    """Exudyn's pin in its bush with a number of steps."""
    sys.exudynFast = True  # read by Exudyn's import
    import exudyn as exu
    from exudyn import itemInterface as item

    system = exu.SystemContainer().AddSystem()
    node = system.AddNode(
        item.NodeRigidBody2D(
            referenceCoordinates=[0, 1e-4, 0],
            initialVelocities=[SPEED * math.cos(TILT), SPEED * math.sin(TILT), 0],
        )
    )
    pin = system.AddObject(item.ObjectRigidBody2D(mass=0.14, inertia=1e-4, nodeNumber=node))
    ground = system.AddObject(item.ObjectGround())
    data = system.AddNode(item.NodeGenericData(initialCoordinates=[0.1, 0, 0, 0], numberOfDataCoordinates=4))
    markers = [system.AddMarker(item.MarkerBodyRigid(bodyNumber=body)) for body in (pin, ground)]
    system.AddObject(
        item.ObjectContactSphereSphere(
            markerNumbers=markers,
            nodeNumber=data,
            spheresRadii=[BORE - C, BORE],
            isHollowSphere1=True,
            contactStiffness=STIFFNESS,
            contactStiffnessExponent=1.5,
        )
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = END
    settings.timeIntegration.numberOfSteps = int(steps)
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.minimumStepSize = 1e-14  # it locates contacts by cutting the step
    settings.solution.file.write = False

    def solve() -> np.ndarray:
        system.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)
        moved = system.GetNodeOutput(node, exu.OutputVariableType.Position)
        return np.array(moved[:2])

    return solve


def cheapest(make: Callable[[float], Solve], grades: list[float], truth: np.ndarray) -> tuple[Solve, float]:
    """The first of ever finer solvers from which on all meet the error, and its error [m]."""
    errors = [float(np.abs(make(grade)() - truth).max()) for grade in grades]
    misses = [n for n, error in enumerate(errors) if not error <= ALLOWED]
    first = misses[-1] + 1 if misses else 0
    if first == len(grades):
        raise SystemExit(f"a solver misses {ALLOWED} m at every grade tried")
    return make(grades[first]), errors[first]


def solver_time(solve: Solve) -> Callable[[], float]:
    """The compiled part of one of rattle's runs [s]."""

    def sample() -> float:
        solve()
        return float(LAST["wall_time"])

    return sample


def slider_crank() -> tuple[Callable[[], object], Callable[[], float]]:
    """The whole call, and the compiled part of it [s], of the slider-crank with play over 24 ms."""
    mechanism = rt.example("slider_crank_play")
    times = np.linspace(0.0, 0.024, 1001)

    def call() -> object:
        return mechanism.simulate(0.024, t_eval=times, rtol=1e-8)

    def compiled() -> float:
        return float(mechanism.simulate(0.024, t_eval=times, rtol=1e-8).stats["wall_time"])

    return call, compiled


def three_plays(repeats: int) -> list[Row]:
    """Three plays under control by time stepping, compiled run time over one second with a step of 0.1 ms."""
    if "three_plays" not in rt.examples():
        return []
    mechanism = rt.example("three_plays")

    def sample() -> float:
        r = mechanism.simulate(1.0, t_eval=[0.0, 1.0], method="moreau", step=1e-4)
        return float(r.stats["wall_time"])

    took = interleave({"moreau": sample}, repeats)["moreau"]
    return [Row("three plays under control, Moreau-Jean 1e-4 s, 1 s", took, aim="50 ms")]


def rows(repeats: int) -> list[Row]:
    """Times of contacts."""
    call, compiled = slider_crank()
    truth = rattle_pin(1e-13)()
    ours, our_error = cheapest(rattle_pin, [10.0**-k for k in range(4, 12)], truth)
    samplers = {"run": compiled, "call": timed(call), "pin call": timed(ours)}
    solver = solver_time(ours)
    samplers["pin"] = solver
    try:
        theirs, error = cheapest(exudyn_pin, [64e3, 128e3, 256e3, 512e3, 1024e3], truth)
        samplers["Exudyn"] = timed(theirs)
    except ImportError:
        theirs, error = None, 0.0
    median = interleave(samplers, repeats)
    found = [
        Row("slider-crank with play, 24 ms, compiled run", median["run"], aim="40 ms"),
        Row("the same, whole call", median["call"]),
        *three_plays(repeats),
    ]
    call_row = Row("the same, whole call", median["pin call"])
    if theirs is None:
        pin = Row("pin in its bush at 1e-8 m, solver", median["pin"], 'Exudyn is missing: pip install ".[bench]"')
        return [*found, pin, call_row]
    yardstick = f"Exudyn (error {error:.1e} m, rattle {our_error:.1e} m)"
    pin = Row("pin in its bush at 1e-8 m, solver", median["pin"], yardstick, median["Exudyn"], "0.02")
    return [*found, pin, call_row]
