"""The paper's four-bar to 0.05 s with both angles right to 1e-6 rad, against Exudyn.

Exudyn's side is set up in its favour: fast build without range checks, crank with a single coordinate and its
speed as a constraint (no Python callback), dense solver, full Newton with the loosest tolerance that does not
cost accuracy, no output files; only its solver is timed.  rattle's time is that of the whole `simulate` call.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

import numpy as np

import rattle as rt
from measure import Row, interleave, timed

END = 0.05
REFERENCE = np.array([0.8548610709, -1.1619901719])  # coupler and rocker angle [rad] at END
ALLOWED = 1e-6  # [rad]
EXUDYN_STEPS = 32_000

Solve = Callable[[], np.ndarray]  # coupler and rocker angle at END


def exudyn_fourbar() -> Solve:
    """Exudyn's four-bar, ready to be solved.

    Bars are 2D rigid bodies, clearance pins distance constraints of length r, integrator generalised-alpha.
    """
    sys.exudynFast = True  # read by Exudyn's import
    import exudyn as exu
    from exudyn import itemInterface as item

    l1, l2, alpha, omega, play, mass, inertia, moment = 0.2, 0.6, math.pi / 3, 10.0, 0.005, 2.0, 0.06, 40.0
    x_o4 = l1 + 2 * l2 * math.cos(alpha) + 2 * play
    rise, run = l2 / 2 * math.sin(alpha), l2 / 2 * math.cos(alpha)
    system = exu.SystemContainer().AddSystem()

    def bar(position: list[float], rates: list[float]) -> tuple[int, int]:
        node = system.AddNode(item.NodeRigidBody2D(referenceCoordinates=position, initialVelocities=rates))
        return node, system.AddObject(item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    def point(body: int, x: float) -> int:
        return system.AddMarker(item.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0, 0]))

    def coordinate(node: int) -> int:
        return system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))

    ground = system.AddObject(item.ObjectGround())
    turn = system.AddNode(item.Node1D(referenceCoordinates=[0], initialVelocities=[omega]))
    crank = system.AddObject(item.ObjectRotationalMass1D(inertia=0.5 * l1**2 / 3, nodeNumber=turn))
    coupler_node, coupler = bar([l1 + run, rise, alpha], [0, l1 * omega, 0])
    rocker_node, rocker = bar([x_o4 - play - run, rise, -alpha], [0, 0, 0])

    o2 = [point(crank, l1), point(coupler, -l2 / 2)]
    o3 = [point(coupler, l2 / 2), point(rocker, -l2 / 2)]
    o4 = [point(rocker, l2 / 2), point(ground, x_o4)]
    motor = [coordinate(system.AddNode(item.NodePointGround())), coordinate(turn)]
    system.AddObject(item.ObjectJointRevolute2D(markerNumbers=o2))
    system.AddObject(item.ObjectConnectorDistance(markerNumbers=o3, distance=play))
    system.AddObject(item.ObjectConnectorDistance(markerNumbers=o4, distance=play))
    system.AddObject(item.ObjectConnectorCoordinate(markerNumbers=motor, offset=omega, velocityLevel=True))
    body = system.AddMarker(item.MarkerBodyRigid(bodyNumber=rocker))
    system.AddLoad(item.LoadTorqueVector(markerNumber=body, loadVector=[0, 0, moment]))
    system.Assemble()

    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = END
    settings.timeIntegration.numberOfSteps = EXUDYN_STEPS
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.timeIntegration.newton.useModifiedNewton = False
    settings.timeIntegration.newton.relativeTolerance = 1e-6
    settings.solution.file.write = False
    settings.linearSolver.solverType = exu.LinearSolverType.EXUdense

    def solve() -> np.ndarray:
        system.SolveDynamic(settings)
        coupler_turn, rocker_turn = (
            system.GetNodeOutput(node, exu.OutputVariableType.Coordinates)[2] for node in (coupler_node, rocker_node)
        )
        return np.array([alpha + coupler_turn, -alpha + rocker_turn])

    return solve


def rattle_fourbar(rtol: float) -> Solve:
    """rattle's four-bar with its adaptive stepper at the given tolerance."""
    mechanism = rt.example("fourbar")

    def solve() -> np.ndarray:
        r = mechanism.simulate(END, t_eval=[0.0, END], rtol=rtol, atol=rtol * 1e-2)
        return np.array([r["coupler.angle"][-1], r["rocker.angle"][-1]])

    return solve


def error(solve: Solve) -> float:
    """Larger error of the two angles [rad]."""
    return float(np.abs(solve() - REFERENCE).max())


def loosest() -> Solve:
    """rattle's four-bar at the loosest tolerance from which on all tighter ones are accurate enough."""
    found = None
    for exponent in np.arange(11.0, 3.0, -0.5):
        solve = rattle_fourbar(10.0**-exponent)
        if error(solve) > ALLOWED:
            break
        found = solve
    if found is None:
        raise SystemExit(f"rattle misses {ALLOWED} rad at every tolerance tried")
    return found


def rows(repeats: int) -> list[Row]:
    """Time to the same accuracy."""
    ours = loosest()
    try:
        theirs = exudyn_fourbar()
    except ImportError:
        median = interleave({"rattle": timed(ours)}, repeats)
        return [Row("four-bar to 0.05 s at 1e-6 rad", median["rattle"], 'Exudyn is missing: pip install ".[bench]"')]
    if error(theirs) > ALLOWED:
        raise SystemExit(f"Exudyn misses {ALLOWED} rad: more steps are needed for a fair comparison")
    median = interleave({"rattle": timed(ours), "Exudyn": timed(theirs)}, repeats)
    yardstick = f"Exudyn (error {error(theirs):.1e}, rattle {error(ours):.1e})"
    return [Row("four-bar to 0.05 s at 1e-6 rad", median["rattle"], yardstick, median["Exudyn"], "0.01")]
