"""The viewer in a notebook: it moves without a kernel where the page computes, else the kernel answers."""

import json
import sys

import numpy as np
import pytest

import rattle as rt
from browsing import becomes
from rattle.errors import MissingPackage
from rattle.pages.notebook import Kernel, kernel_scene, module_text, view, widget_class
from rattle.results.archive import package

STOPPED = """format = 1
name = "a ball on a stop"
gravity = [0, "-9.81 m/s^2"]
parameters.e = { value = 0.5, min = 0, max = 0.9 }
ground.points = { O = [0, 0] }
bodies.ball = { points = { P = [0, 0] }, mass = 1, inertia = 1 }
initial.ball = { x = 1 }
simulate = { t_end = 0.2, output = "10 ms" }
[joints.rail]
type = "prismatic"
connect = ["ground.O", "ball.P"]
angle = 0
axis = "-90 deg"
stop = { max = 0.1, contact = { model = "impact", restitution = "e" } }
"""
SLIDER = """format = 1
name = "a mass on a rail"
parameters.F = { value = 0.5, min = 0.1, max = 1 }
ground.points = { O = [0, 0] }
bodies.block = { points = { P = [0, 0] }, mass = 1, inertia = 1 }
loads.push = { type = "force", at = "block.P", force = ["F", 0] }
simulate = { t_end = 0.2, output = "10 ms" }
joints.rail = { type = "prismatic", connect = ["ground.O", "block.P"], angle = 0 }
"""
# a page that does what a notebook does with the module of a widget: a model with traits and messages
HOST = """<!DOCTYPE html><link rel="icon" href="data:,"><div id="here"></div>
<script type="text/plain" id="module">%s</script>
<script type="module">
const text = document.getElementById("module").textContent;
const { default: widget } = await import(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
const listeners = [], traits = %s;
const model = { get: (name) => traits[name], on: (_, call) => listeners.push(call), off: () => { window.ended = true; },
  send: (message) => window.sent.push(message) };
window.sent = [];
window.answer = (message) => listeners.forEach((call) => call(message));
const el = document.getElementById("here");
window.close = widget.render({ model, el });
window.app = el.rattle;
</script>"""


@pytest.fixture(scope="module")
def stopped():
    return rt.loads(STOPPED)


def answers(kernel, *messages):
    sent = []
    for one in messages:
        kernel.ask(sent.append, one)
    kernel.wait()
    return sent


def wish(number, **parameters):
    return {"do": "compute", "id": number, "parameters": parameters, "t_end": None}


def test_the_kernel_computes_what_the_page_asks_for(stopped):
    heard, answer = answers(Kernel(stopped, None), wish(7, e=0.8))
    assert heard == {"id": 7}
    run = answer["run"]
    want = stopped.set(e=0.8).simulate()
    assert run["n"] == len(want.t)
    assert run["parameters"]["e"] == 0.8
    assert [event[0] for event in run["events"]] == [one.t for one in want.events]
    json.dumps(answer, allow_nan=False)


def test_every_wish_is_answered_and_the_latest_is_computed(stopped):
    kernel = Kernel(stopped, None)
    sent = answers(kernel, wish(1, e=0.1), wish(2, e=0.2), wish(3, e=0.3), wish(4, e=0.4))
    done = {one["id"]: one for one in sent if "run" in one or "error" in one}
    assert sorted(done) == [1, 2, 3, 4]
    assert done[4]["run"]["parameters"]["e"] == 0.4
    assert all("error" in done[n] or done[n]["run"]["parameters"]["e"] == n / 10 for n in (1, 2, 3))
    assert kernel._dropped == set()


def test_a_wish_that_is_called_off_is_not_computed(stopped):
    kernel = Kernel(stopped, None)
    sent = answers(kernel, {"do": "cancel", "id": 9}, wish(9, e=0.2))
    assert "asked for meanwhile" in sent[-1]["error"]


def test_a_value_that_cannot_be_is_refused_in_words(stopped):
    for bad in (wish(1, e=-1.0), wish(1, nothing=1.0)):
        sent = answers(Kernel(stopped, None), bad)
        assert sent[-1]["error"]
        assert "run" not in sent[-1]


def test_the_scene_of_the_kernel_has_sliders_and_says_why(stopped):
    scene = kernel_scene(stopped, None, "contacts begin and end")
    assert [one["name"] for one in scene["knobs"]] == ["e"]
    assert (scene["knobs"][0]["min"], scene["knobs"][0]["max"]) == (0.0, 0.9)
    assert "contacts begin and end" in scene["notes"][-1]


def test_without_anywidget_it_says_what_to_install(monkeypatch, stopped):
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(MissingPackage, match=r"m\.view\(\) needs anywidget; install it with: pip install anywidget"):
        stopped.view()
    with pytest.raises(MissingPackage, match=r"r\.view\(\) needs anywidget"):
        stopped.simulate(0.01).view()
    monkeypatch.undo()
    assert package("json", "anything") is json


def host(widget):
    traits = json.dumps({"scene": widget.scene, "by_kernel": widget.by_kernel}).replace("</", "<\\/")
    return HOST % (module_text(), traits)


def opened(open_page, tmp_path, widget):
    pytest.importorskip("anywidget")
    path = tmp_path / "notebook.html"
    path.write_text(host(widget), encoding="utf-8")
    page = open_page(path.as_uri())
    page.wait_for_function("window.app && window.app.names.length > 5", timeout=60000)
    return page


def test_a_widget_is_live_without_a_kernel(open_page, tmp_path):
    m = rt.loads(SLIDER)
    widget = view(m)
    assert not widget.by_kernel
    page = opened(open_page, tmp_path, widget)
    for force in (0.5, 0.8):
        got = page.evaluate("async (force) => { await app.set('F', force); return app.curve('block.x'); }", force)
        np.testing.assert_allclose(got["y"], 0.5 * force * np.array(got["t"]) ** 2, rtol=0.0, atol=1e-9)
    assert page.evaluate("window.sent.length") == 0


SECOND = """() => {
  const place = document.createElement("div"), { words, language, ...scene } = app.viewer.scene;
  document.body.append(place);
  window.other = app.mount(place, scene);
}"""


def test_views_of_one_notebook_may_have_their_own_languages(open_page, tmp_path):
    """With the title and the curves that were asked for; the viewer is one module for all of them."""
    pytest.importorskip("anywidget")
    m = rt.loads(SLIDER)
    page = opened(open_page, tmp_path, m.view(title="Ein Klotz", curves=["block.vx"], language="de"))
    page.evaluate(SECOND)
    becomes(page, "() => other.names.length > 5 && other.viewer.curves.chosen.length > 0")
    assert page.evaluate("app.viewer.curves.chosen") == ["block.vx"]
    assert page.evaluate("[app.viewer, other.viewer].map(({ parts }) => parts.title.textContent)") == ["Ein Klotz"] * 2
    page.evaluate("[app, other].forEach(({ viewer }) => viewer.trace('block', true))")
    assert page.evaluate("[app, other].map(({ viewer }) => viewer.tools.traces.textContent)") == [
        "Bahnen (1)",
        "Paths (1)",
    ]
    with pytest.raises(ValueError, match=r"no curve 'block\.v'; did you mean"):
        m.view(curves=["block.v"])


def test_a_slider_of_a_widget_is_answered_by_the_kernel(open_page, tmp_path, stopped):
    kernel = Kernel(stopped, None)
    widget = widget_class("m.view()")(kernel_scene(stopped, None, "a law is written in Python"), kernel, "")
    assert widget.by_kernel
    page = opened(open_page, tmp_path, widget)
    page.evaluate("window.done = app.set('e', 0.8); 0")
    page.wait_for_function("window.sent.length > 0")
    asked = page.evaluate("window.sent.at(-1)")
    assert asked["parameters"]["e"] == 0.8
    for one in answers(widget.kernel, asked):
        page.evaluate("(one) => window.answer(one)", one)
    page.evaluate("window.done")
    want = stopped.set(e=0.8).simulate()
    got = page.evaluate("app.curve('ball.y')")
    np.testing.assert_allclose(got["y"], want["ball.y"], rtol=0.0, atol=1e-6)  # single precision
    page.evaluate("window.close()")
    assert page.evaluate("window.ended")
    assert page.evaluate("document.getElementById('here').childElementCount") == 0


def test_where_widgets_are_not_shown_there_is_a_drawing(stopped):
    pytest.importorskip("anywidget")
    bundle = view(stopped)._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    assert "<svg" in data["text/html"]
    assert "widget-view" in " ".join(data)
    r = stopped.simulate(0.02)
    assert r.view().by_kernel is False
