"""A result in closed form, for the tests of results and pictures.

A pin runs round in its bush at constant rate: e = c (cos a, sin a), a = OMEGA t, with the normal force
N = STEADY + SWING cos a, which is negative where the pin would have to be pulled.
"""

import numpy as np

from rattle.results.event import Event
from rattle.results.result import Result
from rattle.results.trust import Trust

C, OMEGA, STEADY, SWING = 0.005, 20 * np.pi, 100.0, 200.0
T_END = 0.2  # two rounds


def circling(n: int = 401, horizon: float | None = 0.15, clearance: float = C, pulls: bool = True) -> Result:
    t = np.linspace(0, T_END, n)
    a = OMEGA * t
    normal = STEADY + SWING * np.cos(a)
    columns = {
        "arm.x": 0.3 + clearance * np.cos(a),
        "arm.y": clearance * np.sin(a),
        "arm.angle": a / 10,
        "O.fx": -normal * np.cos(a),
        "O.fy": -normal * np.sin(a),
        "O.ex": clearance * np.cos(a),
        "O.ey": clearance * np.sin(a),
        "O.normal": normal,
        "lift": np.sin(a),
    }
    units = {name: {"angle": "rad"}.get(name.split(".")[-1], "m") for name in columns}
    units |= {"O.fx": "N", "O.fy": "N", "O.normal": "N", "lift": ""}
    leave = np.arccos(-STEADY / SWING) / OMEGA  # N = 0 on the way down
    rounds = 2 * np.pi / OMEGA * np.arange(2)[:, None]
    pulled = np.array([[leave, 2 * np.pi / OMEGA - leave]]) + rounds
    joint = {"type": "revolute", "bodies": ["ground", "arm"], "points": [[0.3, 0.0], [0.0, 0.0]]}
    return Result(
        t=t,
        data=np.column_stack(list(columns.values())),
        names=columns,
        units=units,
        geometry={
            "bodies": {"arm": {"points": {"O": [0.0, 0.0], "P": [0.1, 0.05]}}},
            "ground": {"points": {"O": [0.3, 0.0]}},
            "joints": {"O": joint | {"clearance": clearance, "contact": "massless-link"}},
            "loads": {},
            "driven": [],
        },
        events=[Event(0.01, "O", "impact", normal_speed=0.5, impulse=0.25)],
        trust=Trust(
            drift=3e-15,
            drift_joint="O",
            energy_balance=2e-9,
            t_end=T_END,
            horizon=horizon,
            pulled={"O": 2 / 3 * 0.5} if pulls else {},
            first_pull={"O": float(leave)} if pulls else {},
            intervals={"O": pulled} if pulls else {},
        ),
        stats={"steps": 12, "smallest": np.float64(1e-5)},
        provenance={"model": "circling"},
    )
