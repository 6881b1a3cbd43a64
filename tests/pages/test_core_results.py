"""What a page makes of the end of a compiled run is the result of `simulate`."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from llvmlite.binding import llvm_version_info

import rattle as rt
from core_engine import RESULT, VIEWER, in_node, new, with_result

TYPICAL = (
    *("crank_rocker_play", "slider_crank_oil", "torque_converter", "belt_drive", "guide_play", "three_plays"),
    *("gear_rattle", "ratchet", "stick_slip"),
)
NOT_RECORDED = ("cam_lift_off",)  # no page computes it: the form of its cam is checked with numbers
EXAMPLES = {path.stem for path in (Path(rt.__file__).parent / "examples").glob("*.toml")}
OTHERS = sorted(EXAMPLES - {*TYPICAL, *NOT_RECORDED})
CLOSE = 1e-12  # share of a column's largest value: sines of NumPy and of the page, and powers as products
SAME_RESULTS = """
import json, sys
from pathlib import Path
import numpy as np
import core_engine
from core_engine import in_node, new, with_result
import rattle as rt
from rattle.analyses.dynamics.report import report
core_engine.use_own_functions()
STEPS = '''run.advance();
  const { resultOf } = await import("%s/core_result.js");
  %s
  const { t: times, columns, units, names, ...others } = resultOf(run, data, functions);
  const values = names.map((one) => Array.from(columns[one], (x) => (Number.isFinite(x) ? x : null)));
  fs.writeFileSync("result.json", JSON.stringify({ ...others, units, names, columns: values }));
''' % (core_engine.VIEWER.as_uri(), core_engine.RESULT)
folder, close, differ = Path(sys.argv[1]), float(sys.argv[2]), {}
nan = lambda x: float("nan") if x is None else x
for name in sys.argv[3:]:
    with_result(folder, rt.example(name))
    said = in_node(folder, new(name), STEPS)
    if "error" in said:
        differ[name] = said["error"]
        continue
    got = json.loads((folder / "result.json").read_text())
    run = new(name)
    run.go()
    want, wrong = report(run, None), []
    if got["names"] != list(want.stored) or got["units"] != {one: want.unit(one) for one in want.stored}:
        wrong.append("names or units")
    else:
        for one, mine in zip(want.stored, got["columns"], strict=True):
            theirs, mine = want[one], np.array([nan(x) for x in mine])
            of = {one.replace("penetration", "ex"), one.replace("penetration", "ey"), one}  # it may be rounding
            size = max(np.abs(want[each][np.isfinite(want[each])]).max(initial=0.0) for each in of)
            bound = 1e-9 if one.endswith("film_pressure") else close  # next to the bush it grows with rounding
            if not np.allclose(mine, theirs, rtol=0.0, atol=bound * size, equal_nan=True):
                wrong.append(one)
    peaks = {key: [nan(x) for x in one] for key, one in got["peaks"].items()}
    if peaks != {key: list(one) for key, one in want.peaks.items()}:
        wrong.append("peaks")
    jolts = [one for one in got["events"] if one["kind"] == "jolt"]
    for one in jolts:  # the work of a driver is not among what a page knows
        one["energy_lost"] = 0.0
    theirs = [one._replace(energy_lost=0.0) if one.kind == "jolt" else one for one in want.events]
    if [tuple(one.values()) for one in got["events"]] != [tuple(one) for one in theirs]:
        wrong.append("events")
    trust = got["trust"]
    for key in ("drift", "drift_angle", "drift_joint", "energy_share", "t_end", "stopped", "pulled", "first_pull",
                "contact_count", "impact_count", "fewest_steps"):
        if trust[key] != getattr(want.trust, {"contact_count": "contacts", "impact_count": "impacts"}.get(key, key)):
            wrong.append(f"trust.{key}")
    if abs(nan(trust["energy"]) - want.trust.energy_balance) > 1e-12 * max(1.0, abs(want["energy.kinetic"]).max()):
        wrong.append("trust.energy")
    if wrong:
        differ[name] = wrong
print(json.dumps(differ))
"""
pytestmark = [
    pytest.mark.skipif(shutil.which("node") is None, reason="no node"),
    pytest.mark.skipif(sys.platform != "linux", reason="elsewhere machine code calls other functions for sine"),
    pytest.mark.skipif(llvm_version_info[0] < 21, reason="older LLVM writes some powers otherwise"),
]


def differing(folder, names):
    """What differs, by example."""
    paths = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", SAME_RESULTS, folder, str(CLOSE), *names],
        env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_typical_results_are_those_of_simulate(tmp_path):
    assert differing(tmp_path, TYPICAL) == {}


def test_the_results_of_all_other_examples_are_those_of_simulate(tmp_path):
    assert differing(tmp_path, OTHERS) == {}


HORIZON = """
run.advance();
  const { resultOf } = await import("%s/core_result.js");
  const { agreement } = await import("%s/core_horizon.js");
  %s
  const finer = { ...image.description, rtol: run.rtol / 10, atol: run.atol / 10 };
  const tight = new CoreRun(engine, { description: finer, content: image.content });
  tight.advance();
  const [first, second] = [run, tight].map((each) => resultOf(each, data, functions));
  fs.writeFileSync("reach.json", JSON.stringify(agreement(first, second, run, data, functions)));
"""


@pytest.mark.parametrize("name", ["gear_rattle", "slider_crank_oil", "double_pendulum"])
def test_the_horizon_of_a_page_is_that_of_simulate(name, tmp_path):
    viewer = VIEWER.as_uri()
    with_result(tmp_path, rt.example(name))
    assert "error" not in in_node(tmp_path, new(name), HORIZON % (viewer, viewer, RESULT))
    reach, trust = json.loads((tmp_path / "reach.json").read_text()), rt.example(name).simulate(horizon=True).trust
    assert reach["time"] == pytest.approx(trust.horizon, rel=0.05)  # rounding of other functions grows
    assert reach["motion"] == pytest.approx(trust.horizon_motion, rel=0.05)
