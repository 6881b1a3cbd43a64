"""Lives of joints and links over duty cases: Archard and Miner by hand, bands, what is first, what is refused."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.errors import InputError, ModelError, SolverError
from rattle.questions.durability.bands import bands, failed

HOUR = 3600.0
D, LENGTH = 0.02, 0.015  # bush and length of the bearing [m]
EXACT = 1e-9  # relative: loads and speeds are constant


def worn(load=400.0, speed=10.0, k=1e-15, limit="0.1 mm", more="", wear="", angle="speed*t"):
    """A rotor in a plain bearing J; load [N] and speed [rad/s] are parameters."""
    return rt.loads(f"""
format = 1
ground.points = {{ O = [0, 0] }}
parameters = {{ load = {load}, speed = {speed} }}
bodies.rotor = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1 }}
drivers.d = {{ joint = "J", angle = "{angle}" }}
loads.f = {{ type = "force", at = "rotor.P", force = [0, "-load"] }}
simulate.t_end = "4*pi/speed"
[joints.J]
type = "revolute"
connect = ["ground.O", "rotor.P"]
friction = {{ model = "coulomb", mu = 0.1, pin_radius = {D / 2} }}
length = {LENGTH}
wear = {{ bush = {k}, limit = "{limit}"{wear} }}
{more}""")


def rate(load, speed, k=1e-15):
    """Depth lost per time [m/s]: k p v."""
    return k * load / (D * LENGTH) * abs(speed) * D / 2


def cell(d, name, column):
    return float(d.table.loc[name, column])


# ---------------------------------------------------------------- joints
@pytest.mark.parametrize(("load", "speed", "k"), [(400.0, 10.0, 1e-15), (35.0, -70.0, 3e-14)])
def test_a_bearing_wears_by_k_p_v(load, speed, k):
    d = worn(load, abs(speed), k, angle=f"{speed}*t").durability()
    assert cell(d, "J", "load") == pytest.approx(load, rel=EXACT)
    assert cell(d, "J", "pressure") == pytest.approx(load / (D * LENGTH), rel=EXACT)
    assert cell(d, "J", "pv") == pytest.approx(load / (D * LENGTH) * abs(speed) * D / 2, rel=EXACT)
    assert cell(d, "J", "wear life") == pytest.approx(1e-4 / rate(load, speed, k) / HOUR, rel=EXACT)
    assert d.first == ("J", "wear", cell(d, "J", "wear life"))


def test_a_pin_that_swings_slides_both_ways():
    """Of 0.5 sin(w t) the mean speed is 0.5 * 2 w/pi; a force (1 + cos^2) is largest where it is fastest."""
    m = worn(angle="0.5*sin(speed*t)").set({"loads.f.force": [0, "-load*(1 + cos(speed*t)**2)"]})
    d = m.durability()
    mean = 0.5 * 10 * (2 / math.pi) * (1 + 2 / 3)  # of |cos| (1 + cos^2) over that of |cos|: 1 + 2/3
    assert cell(d, "J", "pv") == pytest.approx(400 / (D * LENGTH) * mean * D / 2, rel=1e-4)  # trapezia of 1000 outputs
    assert cell(d, "J", "load") == pytest.approx(800.0, rel=EXACT)


def test_means_are_those_of_the_last_turn_and_not_of_the_start():
    m = worn().set({"loads.f.force": [0, "-load*(1 + 50*exp(-20*t))"]})
    start = 2 * math.pi / 10
    mean = 1 + 50 * (math.exp(-20 * start) - math.exp(-40 * start)) / (20 * start)
    d = m.durability()
    assert cell(d, "J", "wear life") == pytest.approx(1e-4 / (rate(400, 10) * mean) / HOUR, rel=1e-4)
    assert cell(d, "J", "load") == pytest.approx(400 * 51, rel=1e-6)  # the largest force is that of the start


CASES = [{"share": 0.7, "set": {"load": 400}}, {"share": 0.3, "set": {"load": 1000, "speed": 20}, "name": "press"}]
TWO = 1e-4 / (0.7 * rate(400, 10) + 0.3 * rate(1000, 20)) / HOUR


@pytest.mark.parametrize("of", [1.0, 10.0])
def test_cases_take_their_share_of_the_life_and_shares_are_proportions(of):
    cases = [{**case, "share": of * case["share"]} for case in CASES]
    d = worn().durability(cases)
    assert cell(d, "J", "wear life") == pytest.approx(TWO, rel=EXACT)
    assert cell(d, "J", "load") == pytest.approx(1000.0, rel=EXACT)
    assert cell(d, "J", "pv") == pytest.approx(1000 / (D * LENGTH) * 20 * D / 2, rel=EXACT)


def test_cases_of_the_model_and_of_a_text_are_the_same():
    written = (
        "duty = { cases = [{ share = 7, set = { load = 400 } }, { share = 3, set = { load = 1000, speed = 20 } }] }"
    )
    m = worn(more="[duty]\n" + written.removeprefix("duty = { ").removesuffix(" }"))
    assert cell(m.durability(), "J", "wear life") == pytest.approx(TWO, rel=EXACT)
    by_text = worn().durability("0.7: load=400; 0.3: load=1 kN, speed=20")
    assert cell(by_text, "J", "wear life") == pytest.approx(TWO, rel=EXACT)


def test_the_film_is_its_least_thickness_over_the_roughness():
    m = rt.example("slider_crank_oil").set({"simulate.t_end": "12 ms"})
    run = m.simulate()
    want = run.films["B"].least_film / m.model.joints["B"].contact.film.roughness
    assert cell(m.durability(), "B", "film") == pytest.approx(want, rel=1e-6)
    assert want <= run["B.lambda_ratio"].min() * (1 + 1e-9)


@pytest.mark.parametrize("place", ["contact.length", "length"])
def test_the_length_of_a_bearing_with_play_is_known_wherever_it_is_written(place):
    m = rt.example("slider_crank_worn")
    joint, contact = "joints.B", dict(m._document["joints"]["B"]["contact"])
    contact = {"model": "lankarani-nikravesh", "restitution": 0.8, "bush_radius": contact["bush_radius"]}
    contact |= {"bush_material": "steel", "pin_material": "steel"}
    m = m.set({f"{joint}.contact": contact, f"{joint}.{place}": "15 mm", f"{joint}.wear": {"bush": 1e-16}})
    assert m.model.joints["B"].length == pytest.approx(0.015)
    assert m.model.joints["B"].wear.length == pytest.approx(0.015)


@pytest.mark.long
def test_a_joint_with_play_lasts_as_long_as_its_map_says():
    limit, jump = 5e-6, 4e4
    m = rt.example("slider_crank_worn").set({"joints.B.wear.limit": limit, "joints.B.wear.jump": jump})
    m = m.set({"joints.B.wear.bins": 60})
    cycle = 2 * math.pi / abs(m.simulate(1e-3)["O.rate"][0])
    study = m.wear(1e15, stop={"depth": limit})
    both = sum(side.deepest for side in study.profile("B"))
    d = m.durability()
    assert cell(d, "B", "wear life") == pytest.approx(study.cycles * cycle * limit / both / HOUR, rel=1e-6)
    assert any("by the map of its wear" in remark for remark in d.remarks)
    assert any(remark.startswith("O, A: no wear life") for remark in d.remarks)


def test_what_is_missing_is_nan_and_said():
    d = worn().set({"joints.J.wear": None, "joints.J.length": None}).durability()
    assert math.isnan(cell(d, "J", "pressure"))
    assert math.isnan(cell(d, "J", "wear life"))
    assert "J: no pressure: length" in "\n".join(d.remarks)
    assert "J: no wear life: it does not say how it wears" in "\n".join(d.remarks)
    assert d.told.startswith("no life is known")
    assert math.isnan(d.first.hours)
    with pytest.raises(InputError, match="no picture of lives"):
        d.plot()


def test_what_never_moves_never_wears():
    d = worn(angle="0*speed*t").durability()
    assert cell(d, "J", "wear life") == math.inf
    assert d.first == ("nothing", "nothing", math.inf)
    assert d.told == "nothing fails of what is known"


# ---------------------------------------------------------------- links
def bar(newton, more="", material=""):
    """A clamped bar of 10 x 10 mm that is drawn and pushed by F sin(pi t) over 2 s: F/100 is its stress in MPa."""
    return rt.loads(f"""
format = 1
parameters.F = {newton}
ground.points = {{ O = [0, 0] }}
loads.f = {{ type = "force", at = "bar.B", force = ["F*sin(pi*t)", 0] }}
simulate = {{ t_end = 2, output = 0.01 }}
[bodies.bar]
bar = ["A", "B"]
length = 0.3
mass = 0.1
section = {{ shape = "rectangle", width = "10 mm", height = "10 mm" }}
material = "iron"
[materials.iron]
E = "210 GPa"
yield = "300 MPa"
{material or 'ultimate = "500 MPa"'}
endurance = "80 MPa"
exponent = 5
[joints.A]
type = "fixed"
connect = ["ground.O", "bar.A"]
{more}""")


def runs(newton):
    return 1e6 * (80 / (newton / 100)) ** 5


def test_a_bar_lasts_as_many_runs_as_its_material_and_miner_adds_up_over_cases():
    d = bar(12000).durability()
    assert cell(d, "bar", "fatigue life") == pytest.approx(runs(12000) * 2 / HOUR, rel=2e-3)  # peaks at outputs
    assert cell(d, "bar", "load") == pytest.approx(12000, rel=1e-3)
    d = bar(12000).durability("0.8: F=12000; 0.2: F=20000")
    want = 2 / HOUR / (0.8 / runs(12000) + 0.2 / runs(20000))
    assert cell(d, "bar", "fatigue life") == pytest.approx(want, rel=2e-3)
    assert cell(d, "bar", "safety") == pytest.approx(300 / 200, rel=2e-3)
    assert d.first.name == "bar"
    assert d.first.what == "fatigue"


def test_a_bar_below_its_endurance_never_tires_and_one_above_its_strength_fails_at_once():
    assert cell(bar(7000).durability(), "bar", "fatigue life") == math.inf
    d = bar(60000).durability()
    assert cell(d, "bar", "fatigue life") == 0.0
    assert "bar fails at once" in d.told


def test_a_material_without_strengths_leaves_the_life_open_and_says_so():
    d = bar(12000, material="density = 7850").durability()
    assert math.isnan(cell(d, "bar", "fatigue life"))
    assert any("no life" in remark for remark in d.remarks)


def test_a_higher_section_is_computed_anew():
    d = bar(12000).durability()
    assert "a height of 12 instead of 10 mm: bar lasts" in d.advice
    assert f"{1.2**5:.3g} times as long" in d.advice  # drawn, not bent: its area is 1.2 times as large


# ---------------------------------------------------------------- bands, advice
def test_bands_are_those_of_a_lognormal_life():
    assert bands(100.0, (0.5, 3.0)) == (50.0, 100.0, 300.0)
    for hours, share in zip(bands(100.0, (0.5, 3.0)), (0.1, 0.5, 0.9), strict=True):
        assert failed(hours, 100.0, (0.5, 3.0)) == pytest.approx(share, rel=EXACT)
    assert failed(10.0, math.inf, (0.5, 2.0)) == 0.0
    assert failed(10.0, 0.0, (0.5, 2.0)) == 1.0
    drawn = 100.0 * np.exp(np.random.default_rng(1).normal(0.0, math.log(2.0) / 1.2815515655, 200_000))
    assert failed(150.0, 100.0, (0.5, 2.0)) == pytest.approx((drawn < 150.0).mean(), abs=5e-3)  # 4 sigma of the draw


def test_bands_are_assumptions_that_are_said_unless_the_model_says_them():
    d = worn().durability()
    life = cell(d, "J", "wear life")
    assert d.bands == pytest.approx((life / 3, life, 3 * life), rel=EXACT)
    assert "assumed, not measured" in str(d)
    d = worn(wear=", band = [0.6, 1.5]").durability()
    assert d.bands == pytest.approx((0.6 * life, life, 1.5 * life), rel=EXACT)
    assert "assumed" not in str(d)


def test_wanted_hours_are_compared_with_the_first_failure():
    assert "lasts 100 h" in worn().durability(hours=100).told
    assert "DOES NOT LAST 1000 h" in worn().durability(hours=1000).told
    assert "50 % have failed by then" in worn().durability(hours=cell(worn().durability(), "J", "wear life")).told


def test_a_longer_bearing_is_computed_anew():
    d = worn().durability()
    longer = worn().set({"joints.J.length": 0.018}).durability()
    assert d.advice == f"a bearing of 18 instead of 15 mm: J lasts 1.2 times as long, {longer.first.hours:.4g} h"


# ---------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("duty", "words"),
    [
        ([], r"expected cases = .* got an empty list"),
        ([{"share": -1, "set": {"load": 3}}], r"share: -1 must be positive"),
        ([{"share": 0}], r"share: 0 must be positive"),
        ([{"share": 1, "set": {"lod": 3}}], r"no parameter 'lod'; did you mean 'load'"),
        ([{"sahre": 1}], r"did you mean 'share'"),
        ("0.7 load=3", r'expected "0.7: M=30'),
        ("0.7: load", r'expected "0.7: M=30'),
        (3, r"duty: expected"),
        ([3], r"duty: expected"),
    ],
)
def test_cases_that_make_no_sense_are_refused(duty, words):
    with pytest.raises(InputError, match=words):
        worn().durability(duty)


@pytest.mark.parametrize("hours", [0, -1, math.nan, math.inf, True])
def test_hours_that_are_none_are_refused(hours):
    with pytest.raises(InputError, match="hours"):
        worn().durability(hours=hours)


def test_a_case_that_cannot_run_is_named():
    m = worn().set({"loads.f.force": [0, "-load*(1 - t)**0.5"]})
    with pytest.raises(SolverError, match="press: its loads are not known"):
        m.durability([{"share": 1, "set": {"speed": 1}, "name": "press"}])


def test_a_model_without_anything_is_refused():
    with pytest.raises(ModelError):
        rt.Mechanism().durability()


# ---------------------------------------------------------------- everywhere
def test_the_command_prints_the_table_and_writes_json_and_a_picture(tmp_path):
    path, picture = tmp_path / "m.toml", tmp_path / "lives.svg"
    worn().save(path)
    run = CliRunner().invoke(main, ["durability", str(path), "--hours", "100", "-o", str(picture)])
    assert run.exit_code == 0
    assert "J fails first, by wear after 208.3 h; lasts 100 h" in run.output
    assert "life [h]" in picture.read_text()
    record = json.loads(CliRunner().invoke(main, ["durability", str(path), "--json"]).output)
    assert record["first"] == {"name": "J", "what": "wear", "hours": pytest.approx(208.3333, rel=1e-6)}
    assert record["rows"][0]["pressure"] == pytest.approx(400 / (D * LENGTH), rel=EXACT)
    assert record["bands"]["early"] < record["bands"]["middle"] < record["bands"]["late"]


def test_samples_of_an_ensemble_have_lives():
    e = worn().ensemble(4, ["final(life)", "final(J.wear_life)"], {"load": 20.0}, analysis="durability", seed=3)
    loads = np.array([e.sample(k).parameters["load"] for k in range(4)])
    assert list(e["final(life)"]) == pytest.approx(1e-4 / rate(loads, 10.0), rel=1e-6)
    assert list(e["final(J.wear_life)"]) == pytest.approx(list(e["final(life)"]))


def test_a_report_has_a_section_where_the_model_says_how_it_wears(tmp_path):
    worn().report(tmp_path / "r.html", t_end=0.1)
    page = (tmp_path / "r.html").read_text()
    assert "<h2>Durability</h2>" in page
    assert "J fails first, by wear after 208.3 h" in page
    assert "<svg" in worn().durability()._repr_html_()


ROLLING = """
format = 1
ground.points.O = [0, 0]
bodies.rotor = { points = { P = [0, 0] }, mass = 1, inertia = 1 }
drivers.d = { joint = "O", angle = "speed*t" }
loads.f = { type = "force", at = "rotor.P", force = [0, "-load"] }
parameters = { load = "10 kN", speed = "1000 rpm" }
simulate.t_end = "2*pi/speed"
[joints.O]
type = "revolute"
connect = ["ground.O", "rotor.P"]
bearing = { number = "6208 C3", capacity = "30.7 kN" }
contact = "ideal"
"""


def test_a_rolling_bearing_lasts_as_iso_281_says():
    """C/P = 3.07 at 1000 rpm: L10 = 482.2 h; half of them reach (ln 2/-ln 0.9)^(1/1.5) = 3.51 times that."""
    basic = 1e6 * 3.07**3 / 1000 / 60
    d = rt.loads(ROLLING).durability()
    assert d.first.name == "O"
    assert d.first.what == "fatigue"
    assert d.bands[0] == pytest.approx(basic, rel=1e-6)
    assert d.first.hours == pytest.approx(basic * (math.log(2) / -math.log(0.9)) ** (1 / 1.5), rel=1e-6)
    assert any("L10 = 482.2 h" in remark for remark in d.remarks)
    cases = [{"share": 1, "set": {"load": "10 kN"}}, {"share": 3, "set": {"load": "5 kN", "speed": "2000 rpm"}}]
    several = 1e6 * 3.07**3 / (0.25 * 1000 + 0.75 * 2000 / 8) / 60
    assert rt.loads(ROLLING).durability(duty=cases).bands[0] == pytest.approx(several, rel=1e-6)


def test_a_report_knows_rolling_bearings(tmp_path):
    rt.loads(ROLLING).report(tmp_path / "r.html")
    assert "<h2>Durability</h2>" in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_a_bar_that_buckles_is_told_beside_its_life():
    d = bar(-30000).durability()
    assert any("BUCKLES" in remark for remark in d.remarks)


def test_a_rolling_bearing_without_capacity_leaves_its_life_open():
    d = rt.loads(ROLLING.replace(', capacity = "30.7 kN"', "")).durability()
    assert math.isnan(d.first.hours)
    assert any("capacity is missing" in remark for remark in d.remarks)
