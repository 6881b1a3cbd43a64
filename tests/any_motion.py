"""Results of all shipped examples with made-up motion: their geometry is real, their numbers are smooth curves."""

import numpy as np

import rattle as rt
from rattle.jit.layout import OUTPUT_BODY
from rattle.results.columns import geometry
from rattle.results.result import Result
from rattle.results.trust import Trust


def any_motion(name: str, n: int = 5, t_end: float = 1.0) -> Result:
    """The example as a result of n instants up to t_end [s]; bodies are anywhere."""
    drawn = geometry(rt.example(name).model)
    t = np.linspace(0.0, t_end, n)
    units = {f"{body}.{key}": unit for body in drawn["bodies"] for key, unit in OUTPUT_BODY.items()}
    for joint, form in drawn["joints"].items():
        keys = ("fx", "fy", "ex", "ey", "normal") if form["contact"] else ("fx", "fy")
        units |= {f"{joint}.{key}": "m" if key in ("ex", "ey") else "N" for key in keys}
    units |= {f"{load}.force": "N" for load, form in drawn["loads"].items() if "coordinate" in form}
    random = np.random.default_rng(1)
    data = np.column_stack([random.normal() + 0.3 * np.sin(t + random.normal()) for _ in units])
    return Result(
        t=t, data=data, names=units, units=units, geometry=drawn, trust=Trust(drift=0.0, t_end=1.0), stats={},
        provenance={"model": name, "parameters": {}},
    )  # fmt: skip
