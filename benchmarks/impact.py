"""Set-valued contacts: compiled run times of both methods, and how their errors fall.

python benchmarks/impact.py
"""

from __future__ import annotations

import numpy as np

import rattle as rt
from measure import Row, interleave, show


def main() -> None:
    """Measure and print."""
    name = "three plays, Moreau-Jean h = 1e-4, 1 s"
    plays, guide, bird = rt.example("three_plays"), rt.example("guide_play"), rt.example("woodpecker")
    ends = [0.0, 1.0]
    samplers = {
        name: lambda: plays.simulate(1.0, t_eval=ends, step=1e-4).stats["wall_time"],
        "three plays, events, 1 s": lambda: plays.simulate(1.0, t_eval=ends, method="event").stats["wall_time"],
        "guide play, events, 0.2 s": lambda: guide.simulate(0.2, t_eval=[0.0, 0.2]).stats["wall_time"],
        "woodpecker, events, 1 s": lambda: bird.simulate(1.0, t_eval=ends).stats["wall_time"],
    }
    times = interleave(samplers, 5)
    aims = {name: "50 ms"}
    show(Row(key, seconds, aim=aims.get(key, "")) for key, seconds in times.items())
    exact = guide.simulate(0.02, t_eval=[0.0, 0.02], rtol=1e-12, atol=1e-14)["crank.angle"][-1]
    print("\nguide play, error of the crank angle at 0.02 s")
    for h in 8e-5 / 2.0 ** np.arange(6):
        end = guide.simulate(0.02, t_eval=[0.0, 0.02], method="moreau", step=float(h))["crank.angle"][-1]
        print(f"  h = {h:.1e} s   {abs(end - exact):.1e} rad")


if __name__ == "__main__":
    main()
