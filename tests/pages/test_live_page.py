"""Live pages in a browser: the motion is computed there, follows its parameters, and says what it cannot vouch for."""

import json
import re
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest

import rattle as rt
from browsing import becomes, frames, keep_picture, shows
from rattle.pages.page import live_scene, page

READY = "() => window.rattle && window.rattle.curve('rocker.angle').t.length > 10"
SET = "([name, value]) => window.rattle.set(name, value).then(() => 'there', (error) => error.message)"
SAID = "() => window.rattle.trust.text.join(' ')"
CURVE = "(name) => { const c = window.rattle.curve(name); return [Array.from(c.t), Array.from(c.y)] }"


PENDULUM = """
format = 1
[parameters]
long = { value = 0.3, min = 0.1, max = 0.5 }
heavy = { value = 2, min = 1, max = 4 }
[ground.points]
O = [0, 0]
[bodies.arm]
bar = ["A", "B"]
length = "long"
mass = "heavy"
[joints.pin]
type = "revolute"
connect = ["ground.O", "arm.A"]
[initial]
arm = { angle = 1, omega = 0 }
[simulate]
t_end = 1
"""


def short_fourbar(**simulate):
    """The four-bar over 0.05 s: what a test can wait for."""
    return rt.example("fourbar").set({"simulate.t_end": 0.05, "simulate.output": 0.0005, **simulate})


@pytest.fixture(scope="module")
def fourbar_page(tmp_path_factory):
    place = tmp_path_factory.mktemp("live") / "fourbar.html"
    assert page(short_fourbar(), place) == ""
    assert place.stat().st_size < 260_000
    return place.as_uri()


@pytest.fixture
def fourbar(fourbar_page, open_page):
    """The page in a tab, its first motion there."""
    tab = open_page(fourbar_page)
    tab.wait_for_function(READY, timeout=60000)
    return tab


@pytest.mark.parametrize(("method", "limit"), [({"simulate.method": "rk4", "simulate.step": 1e-4}, 1e-9), ({}, 1e-6)])
def test_the_page_computes_the_motion_of_simulate(method, limit, tmp_path, open_page):
    """At equal steps but for rounding; the usual method against one with much tighter tolerances."""
    m = short_fourbar(**method)
    page(m, tmp_path / "m.html")
    tab = open_page((tmp_path / "m.html").as_uri())
    tab.wait_for_function(READY, timeout=60000)
    for r3 in (0.005, 0.003):
        assert tab.evaluate(SET, ["r3", r3]) == "there"
        t, y = map(np.array, tab.evaluate(CURVE, "rocker.angle"))
        tight = {} if method else {"rtol": 1e-12, "atol": 1e-14}
        want = m.set(r3=r3).simulate(t_eval=t, **tight)["rocker.angle"]
        near = t <= 0.03  # later, chaos tells even such runs apart
        assert np.abs(y - want)[near].max() < limit
        assert tab.evaluate("() => window.rattle.parameters.r3") == r3


def test_two_hundred_quick_moves_end_with_one_worker_and_the_last_value(fourbar):
    found = fourbar.evaluate("""async () => {
        const said = [];
        for (let k = 0; k < 200; k++) {
            said.push(window.rattle.set("r3", 0.001 + 0.00004 * k));
            if (k % 5 === 0) await new Promise((resolve) => setTimeout(resolve, 4));
        }
        const ends = await Promise.allSettled(said);
        return [ends.every((one) => one.status === "fulfilled"), window.rattle.parameters.r3];
    }""")
    assert found == [True, 0.001 + 0.00004 * 199]
    assert len(fourbar.workers) == 1


def test_a_slider_moves_the_motion_and_the_drawing(fourbar):
    before = fourbar.evaluate(CURVE, "rocker.angle")[1]
    slider = fourbar.get_by_role("slider", name="r3")
    slider.focus()
    slider.press("ArrowRight")
    becomes(fourbar, "() => window.rattle.run.parameters.r3 !== 0.005")
    after = fourbar.evaluate(CURVE, "rocker.angle")[1]
    assert max(abs(a - b) for a, b in zip(before, after, strict=True)) > 1e-6
    becomes(fourbar, "() => rattle.run.geometry.joints.O3.clearance === rattle.parameters.r3")
    slider.dblclick()
    fourbar.wait_for_function("() => window.rattle.parameters.r3 === 0.005")


def test_numbers_are_typed_with_units_and_nonsense_is_refused_in_words(fourbar):
    box = fourbar.get_by_label("r3 in mm")
    assert box.input_value() == "5"
    for text, value in (("2 mm", 0.002), ("0.004 m", 0.004), ("3", 0.003)):
        box.fill(text)
        box.press("Enter")
        fourbar.wait_for_function(f"() => window.rattle.parameters.r3 === {value}")
    box.fill("5 kg")
    box.press("Enter")
    shows(fourbar.get_by_role("alert").filter(has_text="'kg' is another quantity"))
    assert fourbar.evaluate("() => window.rattle.parameters.r3") == 0.003


def test_limits_are_told_in_the_unit_that_is_shown(tmp_path, open_page):
    """And not in that of the arrays: whoever turns rpm thinks in rpm."""
    page(rt.example("slider_crank_play").set({"simulate.t_end": 0.002}), tmp_path / "page.html")
    tab = open_page((tmp_path / "page.html").as_uri())
    box = tab.get_by_label("speed in rpm")
    box.fill("5")
    box.press("Enter")
    said = "speed = 5 rpm is outside of its limits: at least 500, at most 8000 rpm"
    shows(tab.get_by_role("alert").filter(has_text=re.compile(said, re.IGNORECASE)))


def test_what_is_said_of_a_value_stays_when_an_earlier_motion_arrives(fourbar):
    """The value is refused at once, the motion asked for before takes longer."""
    said = fourbar.evaluate("""async () => {
        const before = rattle.set("r3", 0.004), refused = rattle.set("r3", -1).catch(({ message }) => message);
        return [await refused, await before.then(() => rattle.error)];
    }""")
    assert said[0] == said[1]
    assert "limits" in said[0]
    shows(fourbar.get_by_role("alert").filter(has_text="limits"))


def test_a_limit_may_be_typed(tmp_path, open_page):
    """20 um times 1e-6 is less than 2e-5 by its last digit."""
    small = PENDULUM.replace("value = 0.3, min = 0.1, max = 0.5", 'value = "30 um", min = "20 um", max = "60 um"')
    page(rt.Mechanism.from_text(small), tmp_path / "page.html")
    tab = open_page((tmp_path / "page.html").as_uri())
    box = tab.get_by_label("long in um")
    for typed, value in (("20", 2e-5), ("60", 6e-5), ("30", 3e-5)):
        box.fill(typed)
        box.press("Enter")
        becomes(tab, f"() => rattle.parameters.long === {value} && rattle.error === null")
    assert tab.locator(".knob.changed").count() == 0


STRETCHED = """
format = 1
gravity = [0, 0]
[parameters]
rod = { value = 0.5, min = 0.1, max = 0.7 }
mass = { value = 1, min = 0.5, max = 2 }
[ground.points]
A = [0, 0]
D = [0.8, 0]
[bodies]
crank = { bar = ["A", "B"], length = 0.2, mass = 1 }
coupler = { bar = ["B", "C"], length = "rod", mass = "mass" }
rocker = { bar = ["C", "D"], length = 0.4, mass = 1 }
[joints]
A = { type = "revolute", connect = ["ground.A", "crank.A"] }
B = { type = "revolute", connect = ["crank.B", "coupler.B"] }
C = { type = "revolute", connect = ["coupler.C", "rocker.C"] }
D = { type = "revolute", connect = ["ground.D", "rocker.D"] }
[drivers.motor]
joint = "A"
angle = "0.5*sin(3*t)"
[initial]
coupler = { angle = 1 }
[simulate]
t_end = 0.2
output = 0.001
"""


@pytest.fixture
def stretched(tmp_path, open_page):
    """The page of a four-bar whose coupler may be turned too short to reach."""
    assert page(rt.loads(STRETCHED), tmp_path / "stretched.html") == ""
    tab = open_page((tmp_path / "stretched.html").as_uri())
    becomes(tab, READY)
    return tab


def test_parameters_that_do_not_close_keep_the_motion_and_say_why(stretched):
    before = stretched.evaluate(CURVE, "rocker.angle")
    assert "cannot be put together" in stretched.evaluate(SET, ["rod", 0.15])
    shows(stretched.get_by_role("alert").filter(has_text="The motion shown is the one before"))
    assert stretched.evaluate(CURVE, "rocker.angle") == before
    assert "outside of its limits" in stretched.evaluate(SET, ["mass", 5.0])
    assert "no parameter" in stretched.evaluate(SET, ["mess", 1.0])
    assert stretched.evaluate(SET, ["mass", 1.0]) != "there"  # the rod still stands where it was refused
    assert stretched.evaluate(SET, ["rod", 0.5]) == "there"
    shows(stretched.get_by_role("alert"), "hidden")


def test_trust_is_said_as_in_python_when_the_second_run_is_done(fourbar):
    fourbar.wait_for_function("() => window.rattle.trust.horizon !== null", timeout=60000)
    said = fourbar.evaluate("() => window.rattle.trust.text")
    want = str(short_fourbar().simulate(horizon=True).trust).splitlines()
    assert said[1] == want[1]
    assert said[0].split("; ")[1] == want[0].split("; ")[1]


def test_two_sets_stand_side_by_side_and_the_address_keeps_them(fourbar, fourbar_page, open_page):
    fourbar.get_by_role("button", name="Compare").click()
    fourbar.evaluate(SET, ["r3", 0.002])
    fourbar.wait_for_function("() => window.rattle.run.label === 'B'")
    becomes(fourbar, "() => rattle.parameters.r3 === 0.002 && rattle.viewer.others[0].run.parameters.r3 === 0.005")
    fourbar.get_by_role("button", name="A", exact=True).click()
    becomes(fourbar, "() => rattle.parameters.r3 === 0.005")
    fourbar.wait_for_function("() => location.hash === '#B=&B.r3=0.002'")
    again = open_page(f"{fourbar_page}#r4=0.001&B.r3=0.002")
    again.wait_for_function(READY, timeout=60000)
    assert again.evaluate("() => window.rattle.parameters.r4") == 0.001
    again.wait_for_function("() => window.rattle.viewer.others.length === 1")


def test_what_is_sent_is_a_model_file_and_a_table(fourbar):
    fourbar.evaluate(SET, ["r3", 0.002])
    fourbar.get_by_role("button", name="Send").click()
    with fourbar.expect_download() as model:
        fourbar.get_by_role("button", name="Model file").click()
    m = (
        rt.load(model.value.path())
        if str(model.value.path()).endswith(".toml")
        else rt.loads(model.value.path().read_text())
    )
    assert m.model.parameters["r3"].value == 0.002
    assert m.model.parameters["r4"].value == 0.005
    fourbar.get_by_role("button", name="Send").click()
    with fourbar.expect_download() as table:
        fourbar.get_by_role("button", name="CSV").click()
    lines = table.value.path().read_text().splitlines()
    assert lines[0].startswith("t [s],")
    assert len(lines) == 102


def test_a_phone_shows_it_all(fourbar_page, open_page):
    tab = open_page(fourbar_page, viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    tab.wait_for_function(READY, timeout=60000)
    frames(tab)
    assert tab.evaluate("() => document.documentElement.scrollWidth") <= 390
    assert tab.evaluate(SET, ["r3", 0.003]) == "there"


def test_a_page_without_workers_computes_too(fourbar_page, browser):
    context = browser.new_context()
    tab = context.new_page()
    tab.add_init_script("delete window.Worker")
    tab.goto(fourbar_page)
    tab.wait_for_function(READY, timeout=60000)
    assert tab.evaluate(SET, ["r3", 0.003]) == "there"
    context.close()


def test_addresses_that_nobody_wrote_are_no_harm(fourbar_page, open_page):
    """What can be read of them counts; an end that is no time, or never comes, does not."""
    tab = open_page(f"{fourbar_page}#%=1&%E0%A4%A=2&r3=0.003&l1=1e400&t_end=Infinity&t_end=-1&x=1&&=&r4")
    tab.wait_for_function(READY, timeout=60000)
    assert tab.evaluate("() => window.rattle.parameters.r3") == 0.003
    assert tab.evaluate(CURVE, "rocker.angle")[0][-1] == 0.05


def test_parameters_may_have_the_names_of_what_else_is_in_an_address(tmp_path, open_page):
    text = PENDULUM.replace("long", "B").replace("heavy", "t_end")
    page(rt.loads(text), tmp_path / "p.html")
    tab = open_page((tmp_path / "p.html").as_uri() + "#B=0.4&t_end=3&.t_end=0.1")
    tab.wait_for_function("() => window.rattle?.run?.t.length > 10")
    assert tab.evaluate("() => [window.rattle.parameters.B, window.rattle.parameters.t_end]") == [0.4, 3]
    assert tab.evaluate(CURVE, "arm.angle")[0][-1] == 0.1
    tab.get_by_role("button", name="Compare").click()
    tab.wait_for_function("() => location.hash === '#B=0.4&t_end=3&.B=&B.B=0.4&B.t_end=3&.t_end=0.1'")


def test_a_model_with_contacts_becomes_runs_to_choose_from(tmp_path, open_page):
    m = rt.example("slider_crank_play").set({"simulate.t_end": 0.002})
    why = page(m, tmp_path / "play.html", over={"c": ["0.2 mm", "0.4 mm"]})
    assert "asked for" in why
    tab = open_page((tmp_path / "play.html").as_uri())
    tab.wait_for_function("() => window.rattle && window.rattle.names.length > 10")
    assert "computed before" in tab.evaluate("() => window.rattle.viewer.scene.notes.join()")
    assert "the curves can be trusted" in tab.evaluate(SAID)  # of the model as it is written
    tab.get_by_role("combobox").first.select_option(label="c = 0.4 mm")
    tab.wait_for_function("() => window.rattle.run.label === 'c = 0.4 mm'")
    assert tab.evaluate(SET, ["c", 0.0002]) == "there"
    assert tab.evaluate("() => window.rattle.run.label") == "c = 0.2 mm"
    assert re.search("was not computed(?! [(])", tab.evaluate(SAID))
    assert "there are" in tab.evaluate(SET, ["c", 0.3])


@pytest.mark.parametrize("over", [{"cc": [1.0]}, {"c": ["5 kg", "-1 mm"]}])
def test_values_that_the_model_does_not_take_are_no_page(over, tmp_path):
    with pytest.raises(rt.ModelError, match=r"no parameter 'cc'|is a mass"):
        page(rt.example("slider_crank_play"), tmp_path / "p.html", over=over)
    assert not list(tmp_path.iterdir())


def test_a_model_without_limits_has_number_boxes(tmp_path):
    """And a model file in a scene is the model again."""
    text = rt.example("fourbar").to_toml()
    bare = rt.loads(
        text.replace('r3 = { value = "5 mm", min = "0.5 mm", max = "10 mm", tol = "0.5 mm" }', "r3 = 0.005")
    )
    scene = live_scene(bare)
    knob = next(one for one in scene["knobs"] if one["name"] == "r3")
    assert (knob["min"], knob["max"], knob["value"]) == (None, None, 0.005)
    assert rt.loads(scene["live"]["model"]).model.parameters["r3"].value == 0.005
    json.dumps(scene, allow_nan=False)


def test_a_host_is_asked_only_when_a_parameter_is_turned(tmp_path, open_page):
    """A notebook whose kernel has gone still shows the motion that it has."""
    m = rt.example("slider_crank_play").set({"simulate.t_end": 0.001})
    page(m, tmp_path / "play.html", over={"c": ["0.2 mm"]})
    text = (tmp_path / "play.html").read_text()
    asking = "(p) => { globalThis.asked = p; return { promise: new Promise(() => {}), cancel() {} }; }"
    host = f"{{ page: true, compute: {asking} }}"
    (tmp_path / "host.html").write_text(text.replace("{ page: true }", host))
    tab = open_page((tmp_path / "host.html").as_uri())
    tab.wait_for_function("() => window.rattle && window.rattle.names.length > 10")
    frames(tab, 8)
    assert tab.evaluate("() => globalThis.asked === undefined")


@pytest.mark.parametrize(
    ("width", "height", "scheme"), [(1366, 768, "light"), (1920, 1080, "dark"), (390, 844, "light")]
)
def test_sliders_and_curves_fit_the_screen(fourbar_page, open_page, width, height, scheme):
    tab = open_page(fourbar_page, viewport={"width": width, "height": height}, color_scheme=scheme)
    tab.wait_for_function(READY, timeout=60000)
    frames(tab)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    keep_picture(tab, f"live-{width}x{height}-{scheme}")


LABELLED = PENDULUM.replace(
    "long = { value = 0.3,", 'long = { label = "length, value = 3", description = "from pin to tip", value = "300 mm",'
)


def test_a_parameter_has_a_label_and_says_what_it_is(tmp_path, open_page):
    """In the unit in which the model file writes it; the model file that leaves the page keeps the label."""
    page(rt.loads(LABELLED), tmp_path / "p.html")
    tab = open_page((tmp_path / "p.html").as_uri())
    becomes(tab, "() => window.rattle?.run?.t.length > 10")
    shows(tab.get_by_role("slider", name="length, value = 3"))
    about = tab.get_by_text("from pin to tip")
    shows(about, "hidden")
    tab.get_by_role("button", name="What length, value = 3 is").click()
    shows(about)
    box = tab.get_by_label("length, value = 3 in mm")
    box.fill("400")
    box.press("Enter")
    becomes(tab, "() => window.rattle.parameters.long === 0.4")
    tab.get_by_role("button", name="Send").click()
    with tab.expect_download() as model:
        tab.get_by_role("button", name="Model file").click()
    m = rt.loads(model.value.path().read_text())
    assert m.model.parameters["long"].value == 0.4
    assert m.model.parameters["long"].title == "length, value = 3 (long)"


def test_a_slider_that_is_refused_leaves_no_error_behind(stretched):
    """What cannot be put together is said beside the sliders; the console stays empty, which the fixture asserts."""
    slider = stretched.get_by_role("slider", name="rod")
    slider.focus()
    for key in ("Home", "ArrowRight"):
        slider.press(key)
        shows(stretched.get_by_role("alert"))
    slider.dblclick()
    shows(stretched.get_by_role("alert"), "hidden")


def test_a_page_has_the_title_the_curves_and_the_words_that_were_asked_for(tmp_path, open_page):
    """Without its reasons trust is still one word: nobody is led to believe what does not hold."""
    m = short_fourbar()
    m.page(tmp_path / "task.html", title="Task 3", curves=["O3.force", "rocker.O3.x"], trust=False)
    tab = open_page((tmp_path / "task.html").as_uri())
    becomes(tab, READY)
    shows(tab.get_by_role("heading", name="Task 3"))
    assert tab.title() == "Task 3"
    becomes(tab, "() => rattle.viewer.curves.chosen.join() === 'O3.force,rocker.O3.x'")
    shows(tab.get_by_text("With limits", exact=True))
    assert tab.get_by_text("why?").count() == 0
    assert tab.get_by_text("constraint error").count() == 0
    with pytest.raises(ValueError, match=r"no curve 'O3\.forse'; did you mean 'O3\.force'"):
        m.page(tmp_path / "no.html", curves=["O3.forse"])
    assert not (tmp_path / "no.html").exists()


def test_a_phone_that_lies_shows_the_mechanism_and_the_whole_player(fourbar_page, open_page):
    for width, height in ((844, 390), (667, 375)):
        tab = open_page(fourbar_page, viewport={"width": width, "height": height}, has_touch=True, is_mobile=True)
        becomes(tab, READY)
        frames(tab)
        player = tab.get_by_role("group", name="Player").bounding_box()
        assert player["y"] + player["height"] <= height + 0.5
        drawing = tab.locator(".mechanism").bounding_box()
        assert drawing["height"] > 0.6 * height
        assert drawing["width"] > 0.35 * width
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        assert tab.evaluate("document.documentElement.scrollHeight") <= height + 1
        keep_picture(tab, f"live-{width}x{height}")


def test_a_phone_that_stands_begins_with_one_line_of_limits(fourbar_page, open_page):
    tab = open_page(fourbar_page, viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    becomes(tab, READY)
    becomes(tab, "() => window.rattle.trust.horizon !== null && !window.rattle.trust.pending")
    frames(tab)
    shows(tab.get_by_text("With limits", exact=True))
    assert tab.locator(".trust .lines").is_hidden()
    assert tab.locator(".trust").bounding_box()["height"] < 50
    assert "would have to pull" in tab.locator(".trust .first").inner_text()
    tab.get_by_text("why?").click()
    shows(tab.locator(".trust .lines"))
    assert tab.locator(".trust .first").is_hidden()
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    keep_picture(tab, "live-phone-limits")


@pytest.mark.parametrize(("width", "height"), [(1366, 768), (1100, 700), (390, 844)])
def test_names_of_parameters_can_be_read_whole(tmp_path, open_page, width, height):
    page(rt.example("slider_crank").set({"simulate.t_end": 0.006}), tmp_path / "page.html")
    tab = open_page((tmp_path / "page.html").as_uri(), viewport={"width": width, "height": height})
    becomes(tab, READY.replace("rocker.angle", "rod.angle"))
    frames(tab)
    names = tab.locator(".knob .name")
    assert {"crank_length", "rod_length"} <= set(names.all_inner_texts())
    cut = names.evaluate_all("(all) => all.filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.title)")
    assert cut == []
    for box in (name.bounding_box() for name in names.all()):
        assert box["width"] > 60  # room for more than two letters of a line
    keep_picture(tab, f"live-names-{width}")


def test_a_long_run_tells_how_far_it_has_come_and_ends_when_it_is_told(fourbar):
    """What was computed before is shown, and said to be a part."""
    until = fourbar.get_by_label("End of the motion")
    until.fill("5000 s")
    until.press("Enter")
    shows(fourbar.get_by_role("status").filter(has_text=re.compile(r"computing … \d+ %")))
    fourbar.get_by_role("button", name="Stop").click()
    becomes(fourbar, "() => rattle.run.success === false")
    assert fourbar.evaluate("() => rattle.run.message").startswith("at t = ")
    assert fourbar.locator(".trust .badge").text_content() == "Stopped"
    until.fill("0.05 s")
    until.press("Enter")
    becomes(fourbar, "() => rattle.run.success === true")


def test_one_stop_ends_the_mechanism_without_play_too(tmp_path, open_page):
    """It waits for the other motion: a ghost of other settings would be no comparison."""
    page(rt.example("slider_crank_play").set({"simulate.t_end": 0.002}), tmp_path / "page.html")
    tab = open_page((tmp_path / "page.html").as_uri())
    becomes(tab, "() => rattle.viewer.ghost")
    until = tab.get_by_label("End of the motion")
    until.fill("5000 s")
    until.press("Enter")
    tab.get_by_role("button", name="Stop").click()
    becomes(tab, "() => rattle.run.t_end === 5000 && rattle.viewer.ghost === null")
    assert tab.locator(".trust .badge").text_content() == "Stopped"
    until.fill("0.002 s")
    until.press("Enter")
    becomes(tab, "() => rattle.run.success && rattle.viewer.ghost")


CHOOSE_ENDS = """async (ends) => {
    const until = rattle.viewer.shadow.querySelector(".until input");
    for (const end of ends) {
        until.value = end;
        until.dispatchEvent(new Event("change"));
        await new Promise((done) => setTimeout(done, 50));
    }
}"""


def test_a_long_run_that_is_out_of_date_is_given_up_though_nothing_else_is_turned(fourbar):
    fourbar.evaluate(CHOOSE_ENDS, ["5000 s", "0.04 s"])
    becomes(fourbar, "() => rattle.run.t_end === 0.04")  # the long one takes minutes


def test_a_second_set_that_is_given_up_is_not_computed_any_more(fourbar):
    fourbar.get_by_role("button", name="Compare").click()
    becomes(fourbar, "() => rattle.viewer.others.length === 1")
    fourbar.evaluate(CHOOSE_ENDS, ["500 s"])
    fourbar.get_by_role("button", name="Compare").click()
    fourbar.evaluate(CHOOSE_ENDS, ["0.04 s"])
    fourbar.wait_for_function("() => rattle.run.t_end === 0.04", timeout=8000)  # the other would take 20 s


def test_a_browser_that_may_not_compute_replays_the_motion_and_says_why(fourbar_page, tmp_path, open_page):
    """Its policy forbids to compile: the bodies move as they did when the page was written."""
    text = unquote(fourbar_page.removeprefix("file://"))
    strict = Path(text).read_text(encoding="utf-8").replace("&#x27;unsafe-eval&#x27;", "")
    (tmp_path / "strict.html").write_text(strict, encoding="utf-8")
    tab = open_page((tmp_path / "strict.html").as_uri())
    for _ in range(100):
        if tab.evaluate("() => window.rattle?.names.length > 3"):
            break
        tab.wait_for_timeout(100)
    assert tab.evaluate("() => window.rattle.live") is False
    notes = " ".join(tab.evaluate("() => window.rattle.viewer.scene.notes"))
    assert "replays the motion of its bodies" in notes
    assert "cannot compile the engine" in notes
    t, y = map(np.array, tab.evaluate(CURVE, "rocker.angle"))
    assert y == pytest.approx(short_fourbar().simulate(t_eval=t)["rocker.angle"], abs=1e-4)


def test_a_file_with_a_damaged_program_replays_and_says_so(fourbar_page, tmp_path, open_page):
    text = Path(unquote(fourbar_page.removeprefix("file://"))).read_text(encoding="utf-8")
    middle = text.index('"packed":"') + 100_000
    (tmp_path / "damaged.html").write_text(f"{text[:middle]}~~~~~{text[middle + 5 :]}", encoding="utf-8")
    tab = open_page((tmp_path / "damaged.html").as_uri())
    becomes(tab, "() => window.rattle?.names.length > 3")
    assert "this file is damaged" in " ".join(tab.evaluate("() => rattle.viewer.scene.notes"))


def test_an_address_with_refused_values_shows_the_model_as_it_is_written(fourbar_page, open_page):
    tab = open_page(f"{fourbar_page}#r3=1e9")
    tab.wait_for_function(READY, timeout=60000)
    becomes(tab, "() => rattle.error !== null")
    assert "outside of its limits" in tab.evaluate("() => rattle.error")
    shows(tab.get_by_role("alert").filter(has_text="The motion shown is that of the model file."))
    assert tab.evaluate("() => rattle.parameters.r3") == 0.005
