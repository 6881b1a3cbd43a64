"""Wear over many cycles: closed forms, conservation, jumps, folders, bad input."""

import json
import math
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import rattle as rt
from rattle.description.schema import schema
from rattle.questions.wear.chebyshev import integrate
from rattle.questions.wear.cycle import Cycles, first_places, merged
from rattle.questions.wear.pictures import factor_of
from rattle.solvers.contacts.wear_march import slide_under

C, R, L, K = 5e-6, 0.01, 0.01, 1e12  # clearance, radius, length, foundation of the bed
BED = R * L * K * C  # 500 N
TURN = 2 * math.pi * (R - C)  # sliding distance of a turn


def bed(load, bush=0.0, pin=0.0, more=""):
    """A pin that turns ten times a second under a steady load along x; load: in units of R L K_w c."""
    return rt.loads(f"""
format = 1
ground.points = {{ O = [0, 0] }}
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1e-3 }}
drivers.spin = {{ body = "pin", coordinate = "angle", angle = "20*pi*t" }}
loads.push = {{ type = "force", at = "pin.P", force = ["{load * BED} - 1e4*pin.vx", "-1e4*pin.vy"] }}
initial.O = {{ offset = [{C}, 0] }}
[joints.O]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = {C}
contact = {{ model = "hertz", geometry = "johnson", bush_material = "steel", length = {L}, bush_radius = {R} }}
wear = {{ bush = {bush}, pin = {pin}, foundation = {K}, cycle = 0.1{more} }}
""")


def rate(sigma, turns):
    """k [m^2/N] for which k K_w s = sigma after so many turns."""
    return sigma / (K * turns * TURN)


def theta_of(kappa):
    """theta_0 of kappa = theta_0/cos theta_0 - sin theta_0."""
    arc = np.linspace(0, 1.55, 400_001)
    return float(np.interp(kappa, arc / np.cos(arc) - np.sin(arc), arc))


def slow_reference(load, sigma, bins=360, steps=200):
    """The same foundation and wear by plain sums: depth/c and V/(R L c) of a bush under a steady load.

    Midpoint rule over bins, explicit steps, the centre of the pin by bisection.
    """
    theta = (np.arange(bins) + 0.5) * 2 * math.pi / bins - math.pi
    h, wide, cos = np.zeros(bins), 2 * math.pi / bins, np.cos(theta)
    for _ in range(steps):
        low, high = 1.0, 10.0
        for _ in range(60):
            e = 0.5 * (low + high)
            borne = (np.maximum(e * cos - 1.0 - h, 0.0) * cos).sum() * wide
            low, high = (e, high) if borne < load else (low, e)
        h = h + sigma / steps * np.maximum(e * cos - 1.0 - h, 0.0)
    return h.max(), h.sum() * wide


def test_a_bush_under_a_steady_load_wears_as_plain_sums_say():
    for sigma, turns, jump in ((2.0, 200, 25), (10.0, 1000, "auto")):
        side = bed(0.1, rate(sigma, turns)).wear(turns, jump).profile("O").bush
        depth, volume = slow_reference(0.1, sigma)
        # 200 explicit steps err by 1e-4, jumps by their square, here 8 of sigma 0.25; "auto" integrates to 1e-3
        assert side.deepest / C == pytest.approx(depth, rel=2e-3)
        assert side.volume / (R * L * C) == pytest.approx(volume, rel=2e-3)
    assert slow_reference(0.1, 10.0) == pytest.approx((0.843985, 1.1043676), rel=1e-3)  # 1600 bins, in the limit


def test_a_stiff_foundation_wears_to_the_envelope_of_the_pin():
    theta = theta_of(1.0)  # kappa = k N s/(R L c)
    w = bed(0.01, rate(100.0, 1000)).wear(1000)
    side = w.profile("O").bush
    # h is short of that of a rigid bush by the penetration, n0 = 0.01 of c at most
    assert side.deepest / C == pytest.approx(1 / math.cos(theta) - 1, abs=0.01)
    assert side.volume / (R * L * C) == pytest.approx(2 * (math.tan(theta) - theta), rel=0.01)
    envelope = np.maximum((1 + side.deepest / C) * np.cos(side.angle) - 1, 0.0) * C
    assert side.depth == pytest.approx(envelope, abs=0.015 * C)
    assert abs(np.angle((side.depth * np.exp(1j * side.angle)).sum())) < 1e-6
    assert w.outcome == "all cycles"
    assert w.columns["cycle"][-1] == pytest.approx(1000, rel=1e-12)
    assert w.simulated < 60


def test_what_turns_under_the_load_wears_alike_all_round_and_nothing_is_lost():
    k = rate(1e-4, 20)
    theta = theta_of(0.1)
    pressed = 2 * BED * (math.tan(theta) - theta)  # int p dA
    w = bed(0.1, k, 2 * k).wear(20, 1)
    bush, pin = w.profile("O")
    assert np.ptp(pin.depth) < 1e-9 * pin.depth.mean()
    assert pin.depth.mean() == pytest.approx(2 * k * pressed * 20 * TURN / (2 * math.pi * R * L), rel=1e-4)
    assert pin.volume == pytest.approx(2 * bush.volume, rel=1e-12)
    assert bush.volume == pytest.approx(bush.depth.sum() * R * L * 2 * math.pi / 360, rel=1e-14)
    assert bush.volume / (k * 0.1 * BED * 20 * TURN) == pytest.approx(1.02697432, rel=1e-4)


def test_a_slider_crank_wears_at_the_ends_of_its_rod_as_its_ideal_forces_say():
    m = rt.example("slider_crank_worn")
    t = np.linspace(0, 0.04, 4001)
    r = m.ideal().inverse_dynamics(t)
    sliding = np.hypot(r["B.fx"], r["B.fy"]) * np.abs(r["rod.omega"]) * (t[1] - t[0]) * 0.01  # N |d beta| R
    bush, pin = m.wear(3, 1).profile("B")
    wear = m.model.joints["B"].wear
    # arcs are 2 x 12 deg wide at most, which adds 1 %; the pin swings a little
    assert bush.volume == pytest.approx(wear.bush * 3 * sliding[:-1].sum(), rel=0.02)
    assert pin.volume == pytest.approx(0.1 * bush.volume, rel=1e-9)
    outer = np.cos(np.arctan2(-r["B.fy"], -r["B.fx"]) - r["rod.angle"]) > 0
    share = sliding[:-1][outer[:-1]].sum() / sliding[:-1].sum()
    assert bush.depth[np.cos(bush.angle) > 0].sum() / bush.depth.sum() == pytest.approx(share, abs=0.01)
    across = np.abs(np.sin(bush.angle)) > math.sin(math.radians(60))
    assert bush.depth[across].sum() < 0.03 * bush.depth.sum()


def test_given_jumps_are_cut_where_they_would_be_unstable_and_halves_show_their_error():
    k = rate(10.0, 1000)
    coarse, fine = (bed(0.1, k).wear(200, jump) for jump in (100, 25))
    exact = slow_reference(0.1, 2.0)[0]
    errors = [abs(one.profile("O").bush.deepest / C - exact) / exact for one in (coarse, fine)]
    assert errors[0] < 0.04  # two jumps of sigma = 1
    assert errors[1] < 0.004
    assert coarse.columns["error"].max() > 3 * fine.columns["error"].max()
    cut = bed(0.1, k).wear(300, 300)
    assert cut.columns["jump"].max() == pytest.approx(100.0, rel=0.01)
    assert any("limit of stability" in one for one in cut.trust)


def test_it_ends_at_a_depth_a_volume_and_the_wall():
    k = rate(10.0, 1000)
    for ends, more, said in (
        ({"depth": 1e-6}, "", "reached the depth"),
        ({"volume": 2e-16}, "", "reached the volume"),
        (None, ", wall = 1e-6", "worn through"),
    ):
        w = bed(0.1, k, more=more).wear(1000, stop=ends)
        assert said in w.outcome
        assert w.cycles < 1000
        side = w.profile("O").bush
        if "volume" in said:
            assert side.volume == pytest.approx(2e-16, rel=1e-9)
        else:
            assert side.deepest == pytest.approx(1e-6, rel=1e-9)
    figure = w.plot()
    written = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert any(f"drawn {factor_of(1e-6 / R):g} times deeper" in one for one in written)
    assert any(one.startswith("bush: 1 ") for one in written)
    worn = w.mechanism.set({"joints.O.wear.wall": 1e-3}).wear(1000, stop={"volume": 1e-16})
    assert worn.cycles == 0.0  # it has lost more than that before
    assert "volume" in worn.outcome
    low, high = w.band("O", "bush")
    assert low < side.deepest < high
    assert w.limiting == ("O", "bush")


def test_smoothing_keeps_the_volume_and_says_what_it_changed():
    k = rate(2.0, 200)
    plain, smooth = (bed(0.1, k, more=more).wear(200, 20) for more in ("", ", smooth = 0.2"))
    one, other = plain.profile("O").bush, smooth.profile("O").bush
    assert other.volume == pytest.approx(one.volume, rel=2e-3)
    assert np.abs(np.diff(other.depth, 2)).max() < np.abs(np.diff(one.depth, 2)).max()
    assert any("smoothing changed" in line for line in smooth.trust)


def test_a_worn_mechanism_is_saved_read_and_run(tmp_path):
    w = bed(0.1, rate(10.0, 1000)).wear(400)
    worn = w.mechanism
    worn.save(tmp_path / "worn.toml")
    assert 'profile = "O.wear.csv"' in (tmp_path / "worn.toml").read_text()
    again = rt.load(tmp_path / "worn.toml")
    assert again.model.joints["O"].wear.profile == worn.model.joints["O"].wear.profile
    assert rt.loads(again.to_toml()).model.joints["O"].wear.profile == worn.model.joints["O"].wear.profile
    depth = w.profile("O").bush
    e = C + depth.deepest
    r = again.set({"initial.O.offset": [e, 0.0]}).simulate(0.1, t_eval=np.linspace(0, 0.1, 11))
    assert r.success
    assert r["O.normal"][-1] == pytest.approx(0.1 * BED, rel=1e-9)
    assert r["O.ex"][-1] > e  # it lies in its hollow
    turnover = np.abs(r["energy.work"]).max() + r["energy.dissipated"].max()
    assert np.abs(r["energy.balance"]).max() < 1e-7 * turnover  # rtol is 1e-8
    further = again.wear(100).profile("O").bush  # and wears on from there
    assert further.deepest > depth.deepest
    (tmp_path / "other.toml").write_text((tmp_path / "worn.toml").read_text().replace("joints.O", "joints.Q"))
    for name, bad, said in (
        ("worn.toml", {"joints.O.wear.bins": 100}, "100 bins, got 360 numbers"),
        ("worn.toml", {"joints.O.wear.profile": "nothing.csv"}, "no file"),
    ):
        with pytest.raises(rt.ModelError, match=said):
            rt.load(tmp_path / name).set(bad)


def test_a_study_in_a_folder_goes_on_to_the_same_bits(tmp_path):
    m = bed(0.1, rate(10.0, 1000), rate(2.0, 1000))
    whole = m.wear(60, 6)

    class Stop(Exception):
        pass

    def tell(done, total):
        if done > 20:
            raise Stop

    with pytest.raises(Stop):
        m.wear(60, 6, out=tmp_path / "study", progress=tell)
    assert (tmp_path / "study" / "O.wear.csv").exists()
    found = m.wear(60, 6, out=tmp_path / "study")
    for one, other in zip(found.profile("O"), whole.profile("O"), strict=True):
        assert (one.depth == other.depth).all()
    assert m.wear(60, 6, out=tmp_path / "study").simulated == found.simulated  # nothing is left to do
    assert rt.load(tmp_path / "study" / "worn.toml").model.joints["O"].wear.profile[0] == tuple(
        whole.profile("O").bush.depth
    )
    with pytest.raises(ValueError, match="another study, its jump differs"):
        m.wear(60, 7, out=tmp_path / "study")
    with pytest.raises(ValueError, match="another study, its model differs"):
        m.set({"joints.O.wear.bush": 1e-13}).wear(60, 6, out=tmp_path / "study")


def test_damaged_folders_are_refused_in_words(tmp_path):
    m = bed(0.1, rate(10.0, 1000))
    m.wear(2, 1, out=tmp_path)
    state, manifest = tmp_path / "state.npz", tmp_path / "manifest.json"
    whole, settings = state.read_bytes(), manifest.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 3] ^= 255
    with np.load(state) as kept:
        arrays = dict(kept)
    for bad in (b"", whole[:5000], bytes(flipped), b"text" * 100):
        state.write_bytes(bad)
        with pytest.raises(ValueError, match=r"is damaged .* remove it to begin anew"):
            m.wear(3, 1, out=tmp_path)
    for bad, said in ((arrays["depths0"][:, :100], "do not have 360 bins"), (arrays["depths0"] * math.nan, "numbers")):
        np.savez(state, **{**arrays, "depths0": bad})
        with pytest.raises(ValueError, match=f"is damaged .*{said}"):
            m.wear(3, 1, out=tmp_path)
    state.write_bytes(whole)
    for bad in (b"", b"[1]", b"null", settings[:50]):
        manifest.write_bytes(bad)
        with pytest.raises(ValueError, match="cannot be read"):
            m.wear(3, 1, out=tmp_path)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"joints.O.wear.bush": {"coefficient": 1e-4}}, "needs hardness"),
        ({"joints.O.wear.bush": "1e-6 mm"}, "m\\^2/N"),
        ({"joints.O.wear.bins": 3}, "whole number from 12"),
        ({"joints.O.wear.smooth": 0.4}, "outside \\[0, 0.25\\]"),
        ({"joints.O.wear.layer": {"E": 1e9, "thickness": 1e-3}}, "not both"),
        ({"joints.O.wear.speed": 3}, "unknown key"),
        ({"joints.O.clearance": 0}, "needs a clearance"),
        ({"joints.O.contact": {"model": "hertz", "stiffness": 1e9, "length": 0.01}}, "needs bush_radius"),
        ({"joints.O.contact": {"model": "hertz", "stiffness": 1e9, "bush_radius": 0.01}}, "needs length"),
    ],
)
@pytest.mark.nojit
def test_bad_input_is_refused_where_it_stands(change, said):
    with pytest.raises(rt.ModelError, match=said):
        bed(0.1, 1e-13).set(change)


@pytest.mark.nojit
def test_questions_without_sense_are_refused():
    m = bed(0.1, 1e-13)
    with pytest.raises(rt.ModelError, match="no joint wears"):
        bed(0.1).wear(10)
    with pytest.raises(rt.ModelError, match="'impact' has no pressure"):
        m.set({"joints.O.contact": {"model": "impact", "bush_radius": R}}).wear(10)
    for arguments, said in (
        ((0,), "cycles"), ((10, 0.5), "at least one cycle"), ((10, "many"), "a number of cycles"),
        ((10, 1, -1.0), "cycle"), ((10, 1, None, {"width": 1}), "stop knows"),
        ((10, math.nan), "jump must be"), ((10, math.inf), "jump must be"),
        ((10, 1, None, {"depth": math.nan}), "stop: depth"), ((10, 1, None, {"volume": 0.0}), "stop: volume"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=said):
            m.wear(*arguments)


@pytest.mark.nojit
def test_the_schema_knows_wear_and_is_json():
    text = json.dumps(schema(), allow_nan=False)
    assert all(f'"{key}"' in text for key in ("foundation", "hardness", "wall", "depths"))


@pytest.mark.nojit
def test_rates_and_layers_are_read_in_their_units():
    m = bed(0.1, 1e-13)
    assert m.set({"joints.O.wear.bush": "2e-6 mm^3/(N*m)"}).model.joints["O"].wear.bush == pytest.approx(2e-15)
    hard = {"coefficient": 1e-4, "hardness": "2 GPa"}
    assert m.set({"joints.O.wear.pin": hard}).model.joints["O"].wear.pin == pytest.approx(5e-14)
    layer = {"E": "2 GPa", "nu": 0.3, "thickness": "0.5 mm"}
    made = m.set({"joints.O.wear": {"bush": 1e-13, "layer": layer}}).model.joints["O"].wear
    assert made.foundation == pytest.approx(0.7 * 2e9 / (1.3 * 0.4 * 0.5e-3))
    hollow = m.set({"joints.O.wear.depths": {"bush": [1e-6] * 360}})
    for model in ("impact", "massless-link"):
        assert any("takes the bush as round" in one for one in hollow.with_contact(model).model.remarks)
    assert not hollow.model.remarks
    oil = {"model": "lubricated", "viscosity": 0.05, "length": L, "bush_radius": R}
    assert hollow.set({"joints.O.contact": oil}).model.joints["O"].worn is None
    with pytest.raises(rt.ModelError, match="oil film of a worn bush is not known"):
        m.set({"joints.O.contact": oil}).wear(10)
    fitted = m.set({"joints.O.wear": {"bush": 1e-13}}).model.joints["O"].wear
    assert "as by 'johnson'" in fitted.assumed


@pytest.mark.nojit
def test_the_stabilised_method_has_its_order_and_its_reach():
    def f(y):
        return np.array([-1e4 * (y[0] - math.cos(y[1])), 1.0])

    ends = [integrate(f, np.array([1.0, 0.0]), 3.0, lambda _: 1e4, tolerance) for tolerance in (1e-3, 1e-5)]
    exact = math.cos(3.0) + math.sin(3.0) / 1e4
    assert [abs(end[0] - exact) for end in ends] == pytest.approx([0.0, 0.0], abs=2e-4)
    assert abs(ends[1][0] - exact) < 1e-6


WORKER = """
import sys
import test_wear
print("begun", flush=True)
test_wear.bed(0.1, test_wear.rate(10.0, 1000)).wear(600, 1, out=sys.argv[1])
"""


def test_nothing_is_lost_when_it_is_killed(tmp_path):
    folder = tmp_path / "study"
    here = __file__.rsplit("/", 1)[0]
    with subprocess.Popen([sys.executable, "-c", WORKER, str(folder)], cwd=here, stdout=subprocess.PIPE) as worker:
        until = time.monotonic() + 120
        while not (folder / "state.npz").exists() and time.monotonic() < until and worker.poll() is None:
            time.sleep(0.05)
        time.sleep(0.3)
        worker.send_signal(signal.SIGKILL)
    with np.load(folder / "state.npz") as kept:
        done = int(kept["numbers"][0])
    assert 1 <= done < 600
    w = bed(0.1, rate(10.0, 1000)).wear(
        600, 1, out=folder, progress=lambda reached, total: (_ for _ in ()).throw(KeyboardInterrupt)
    )
    assert w.interrupted
    assert w.cycles == done + 1


@pytest.mark.nojit
def test_accuracy_knows_the_hollow_of_a_worn_bush():
    m = rt.example("slider_crank_worn")
    theta = (np.arange(360) + 0.5) * math.pi / 180

    def worst(bush):
        worn = m.set({"joints.B.wear.depths": {"bush": bush.tolist()}})
        return np.abs(worn.accuracy("slider.x", [0.0, 0.01, 0.02], loaded=False).worst)

    round_, wide, along = (worst(one) for one in (0 * theta, 1e-5 + 0 * theta, 3e-5 * np.maximum(np.cos(theta), 0.0)))
    assert round_ == pytest.approx(np.abs(m.accuracy("slider.x", [0.0, 0.01, 0.02], loaded=False).worst), rel=1e-4)
    assert wide == pytest.approx(round_ * 4.0 / 3.0, rel=1e-4)  # a bush that is 10 um wider than 30
    assert along[0] == pytest.approx(
        2.0 * round_[0], rel=1e-3
    )  # twice as far along the rod, whose bush is hollow there


def test_loads_of_a_hammering_pin_wear_at_rest_where_they_wore_in_the_run(monkeypatch):
    """Loads that are put together lose their spread: the same work, but on a narrower arc."""
    seen, run = [], Cycles.run

    def kept(self, depths, state):
        seen.append((self, depths, run(self, depths, state)))
        return seen[-1][2]

    monkeypatch.setattr(Cycles, "run", kept)
    theta = (np.arange(360) + 0.5) * 2 * math.pi / 360
    hollow = np.maximum(33e-6 * np.abs(np.cos(theta)) - 30e-6, 0.0).tolist()
    rt.example("slider_crank_worn").set({"joints.B.wear.depths": {"bush": hollow}}).wear(2, 1)
    cycles, depths, found = seen[-1]
    p = cycles.pins[0].parameters(cycles.system.arrays["values"], depths[0])
    arcs = found.work[0][0].reshape(36, 10).sum(axis=1)
    fewer = merged(found.loads[0])
    assert len(fewer) < 0.7 * len(found.loads[0])
    assert fewer.sum(axis=0) == pytest.approx(found.loads[0].sum(axis=0), rel=1e-9)
    for loads in (found.loads[0], fewer):
        made, sums = np.zeros(720), np.zeros(5)
        slide_under(p, loads, first_places(cycles.pins[0], loads), made, sums)
        assert made[:360].reshape(36, 10).sum(axis=1) == pytest.approx(arcs, abs=0.03 * arcs.max())
