"""What a page makes of the end of a compiled run is the result of `simulate`."""

import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from llvmlite.binding import llvm_version_info

import rattle as rt
from core_engine import RESULT, VIEWER, in_node, new, with_result
from linkages import SCISSOR, fourbar_text

TYPICAL = (
    *("crank_rocker_play", "slider_crank_oil", "torque_converter", "belt_drive", "guide_play", "three_plays"),
    *("gear_rattle", "ratchet", "stick_slip"),
)
NOT_RECORDED = ("cam_lift_off",)  # no page computes it: the form of its cam is checked with numbers
EXAMPLES = {path.stem for path in (Path(rt.__file__).parent / "examples").glob("*.toml")}
LEAN = ("dominoes",)  # at rest they lean on each other: whether forces are told to be unique is rounding
OTHERS = sorted(EXAMPLES - {*TYPICAL, *NOT_RECORDED, *LEAN})
CLOSE = 1e-12  # share of a column's largest value: sines of NumPy and of the page, and powers as products
SAME_RESULTS = """
import json, re, sys
from pathlib import Path
import numpy as np
import core_engine
from core_engine import in_node, new, with_result
import rattle as rt
from rattle.analyses.dynamics.horizon import agreement
from rattle.analyses.dynamics.methods import note_choice
from rattle.analyses.dynamics.report import report
from rattle.pages.live_model import live_model
from rattle.results import contact_summary
from rattle.results.contact_summary import contact_lines
from rattle.results.trust import HOW
core_engine.use_own_functions()
STEPS = '''run.advance();
  const { curves, resultOf } = await import("%s/core_result.js");
  %s
  const { breaks: beside, rows: raw } = run.result(), flat = Float64Array.from(beside.flatMap(({ row }) => [...row]));
  const sides = beside.length ? curves(run, data, functions, data.values, flat, raw.subarray(0, data.width)) : {};
  const instants = Float64Array.from(beside, ({ t }) => t);
  const between = Object.fromEntries(Object.entries(sides).map(([name, y]) => [name, { t: instants, y }]));
  const { t: times, columns, units, names, ...others } = resultOf(run, data, functions);
  const { trusted } = await import("%s/trust_words.js"), { shownOf } = await import("%s/core_unread.js");
  const reach = JSON.parse(fs.readFileSync("reach.json"));
  const words = trusted({ ...others.trust, ...reach, pending: false }, data.told.sentences.trust);
  const events = others.events.map(Object.values);
  const shown = shownOf({ t: times, columns, units, names, ...others, events }, data.told, between);
  const cut = names.filter((name) => shown.columns[name] !== columns[name]);
  const unread = shown.events.filter((event) => event[5] === null).map(([, joint]) => joint);
  fs.writeFileSync("said.json", JSON.stringify({ ...words, cut, unread_events: [...new Set(unread)].sort() }));
  const values = names.map((one) => Array.from(columns[one], (x) => (Number.isFinite(x) ? x : null)));
  fs.writeFileSync("result.json", JSON.stringify({ ...others, units, names, columns: values }));
''' % (core_engine.VIEWER.as_uri(), core_engine.RESULT, core_engine.VIEWER.as_uri(), core_engine.VIEWER.as_uri())
NUMBER = re.compile(r"[-+]?\\d[\\d.]*(e[-+]?\\d+)?")
LOSE = re.compile(r": constraints of [^;]* lose rank")  # a page does not tell which
bare = lambda lines: [NUMBER.sub("#", LOSE.sub("", line)) for line in lines]
folder, close, differ = Path(sys.argv[1]), float(sys.argv[2]), {}
nan = lambda x: float("nan") if x is None else x
for name in sys.argv[3:]:
    with_result(folder, rt.example(name), names=list(live_model(rt.example(name), alone=True).parameters))
    run, second = new(name), new(name, finer=10.0)
    run.notes = note_choice(run.system, run.system.model.settings.method, run.stepper)
    run.go()
    second.go()
    reach = agreement(run, second)
    numbers = {"horizon": reach.time, "horizon_curve": reach.first, "horizon_motion": reach.motion}
    (folder / "reach.json").write_text(json.dumps(numbers))
    said = in_node(folder, new(name), STEPS)
    if "error" in said:
        differ[name] = said["error"]
        continue
    got = json.loads((folder / "result.json").read_text())
    want, wrong = report(run, reach), []
    if got["names"] != list(want.stored) or got["units"] != {one: want.unit(one) for one in want.stored}:
        wrong.append("names or units")
    else:
        for one, mine in zip(want.stored, got["columns"], strict=True):
            theirs, mine = want[one], np.array([nan(x) for x in mine])
            of = {one.replace("penetration", "ex"), one.replace("penetration", "ey"), one}  # it may be rounding
            size = max(np.abs(want[each][np.isfinite(want[each])]).max(initial=0.0) for each in of & {*want.names})
            bound = 1e-9 if one.endswith("film_pressure") else close  # next to the bush it grows with rounding
            if not np.allclose(mine, theirs, rtol=0.0, atol=bound * size, equal_nan=True):
                wrong.append(one)
    peaks = {key: [nan(x) for x in one] for key, one in got["peaks"].items()}
    if peaks != {key: list(one) for key, one in want.peaks.items()}:
        wrong.append("peaks")
    if [tuple(event.values()) for event in got["events"]] != [tuple(event) for event in want.events]:
        wrong.append("events")
    trust = got["trust"]
    for key in ("drift", "drift_angle", "drift_joint", "energy_share", "t_end", "stopped", "pulled", "first_pull",
                "fewest_steps"):
        if trust[key] != getattr(want.trust, key):
            wrong.append(f"trust.{key}")
    if (trust["contact_count"], trust["impact_count"]) != (want.trust.contacts, want.trust.impacts):
        wrong.append("counts of contacts")
    words = json.loads((folder / "said.json").read_text())
    told = {"text": str(want.trust).splitlines(), "limits": [want.trust.word] if want.trust.excepts else [],
            "word": [want.trust.word], "contacts": contact_lines(want)}
    for key, lines in told.items():
        mine = [words[key]] if key == "word" else words[key]
        if bare(mine) != bare(lines):
            wrong.append({key: [mine, lines]})
    towering = want.trust.unread and contact_summary.towering(want, want.stored)
    unread = sorted(name for name, summary in want.contacts.items() if not summary.readable)
    mine = words["unread"], sorted(words["cut"]), words["unread_events"]
    if mine != (list(want.trust.unread), sorted(towering), unread):
        wrong.append({"unread": [mine, want.trust.unread, towering, unread]})
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


@pytest.mark.long
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


PEAKS = """run.advance();
  const { resultOf } = await import("%s/core_result.js");
  %s
  fs.writeFileSync("peaks.json", JSON.stringify(resultOf(run, data, functions).peaks));
"""


LIGHT = fourbar_text('joint = "A"\nangle = "7*t"', 0.1, 0.35, 0.25, 0.4, "crank = { angle = 0 }").replace(
    "mass = 2", "mass = 2e-9"
)


@pytest.mark.parametrize(("text", "end"), [(SCISSOR, 0.32), (LIGHT, 0.05)])
def test_peaks_of_a_run_that_ends_beside_a_singular_position_are_those_before_it(text, end, tmp_path):
    m = rt.loads(text)
    with_result(tmp_path, m, end)
    assert "error" not in in_node(tmp_path, new(m, t_end=end), PEAKS % (VIEWER.as_uri(), RESULT))
    peaks, want = json.loads((tmp_path / "peaks.json").read_text()), m.simulate(end).peaks
    assert {*peaks} == {*want}
    for name in want:
        value = [math.nan if x is None else x for x in peaks[name]]
        assert value == pytest.approx(want[name], rel=1e-6, nan_ok=True)


@pytest.mark.parametrize("name", ["gear_rattle", "slider_crank_oil", "double_pendulum"])
def test_the_horizon_of_a_page_is_that_of_simulate(name, tmp_path):
    viewer = VIEWER.as_uri()
    with_result(tmp_path, rt.example(name))
    assert "error" not in in_node(tmp_path, new(name), HORIZON % (viewer, viewer, RESULT))
    reach, trust = json.loads((tmp_path / "reach.json").read_text()), rt.example(name).simulate(horizon=True).trust
    assert reach["time"] == pytest.approx(trust.horizon, rel=0.05)  # rounding of other functions grows
    assert reach["motion"] == pytest.approx(trust.horizon_motion, rel=0.05)
