"""The viewer in a notebook, as an anywidget: a mechanism with sliders, or the motion of one result.

A mechanism that can be recorded computes its motion in the browser, also in a saved notebook that is opened without a
kernel.  Others are computed by the kernel, in a thread, so that it answers meanwhile.
"""

from __future__ import annotations

import functools
import json
import threading
from importlib.resources import files
from typing import Any

from rattle.errors import AssemblyError, ModelError, TraceError
from rattle.mechanism import Mechanism
from rattle.pages.page import live_scene, words_of
from rattle.pages.scene import run_of, scene_json, scene_of
from rattle.pages.viewer_text import viewer_text
from rattle.pages.wishes import AS_USUAL, Wishes
from rattle.plots.diagram import drawing
from rattle.results.archive import package
from rattle.results.columns import geometry
from rattle.results.display import card
from rattle.results.result import Result
from rattle.value_types import Tree

LATER = {"error": "another motion was asked for meanwhile"}


def view(m: Mechanism, t_end: float | None = None, wishes: Wishes = AS_USUAL) -> Any:
    """A widget with the mechanism, sliders for its parameters, curves and trust; see `Mechanism.view`."""
    kind = widget_class("m.view()")
    try:
        scene, by_kernel = live_scene(m, t_end), None
    except TraceError as error:
        scene, by_kernel = kernel_scene(m, t_end, str(error)), Kernel(m, t_end)
    return kind(wishes.of(scene), by_kernel, _still(m))


def view_result(r: Result, wishes: Wishes = AS_USUAL) -> Any:
    """A widget that plays one result; see `Result.view`."""
    kind = widget_class("r.view()")
    return kind(wishes.of(scene_of([("", r)])), None, r._repr_html_())


def kernel_scene(m: Mechanism, t_end: float | None, why: str) -> dict[str, Any]:
    """The scene of a mechanism whose motions the kernel computes: the first of them, and its sliders.

    why: the reason why the page cannot.  Raises ModelError, AssemblyError.
    """
    scene = scene_of([("", m.simulate(t_end).whole())], title=m.name)
    knobs = [
        {
            "name": name, "value": knob.value, "unit": knob.unit, **words_of(m, name), "shown": m.written_unit(name)[1],
            "min": knob.minimum, "max": knob.maximum,
        }
        for name, knob in m.model.parameters.items()
        if knob.minimum is not None and knob.maximum is not None
    ]  # fmt: skip
    note = f"sliders are answered by the kernel of this notebook, because {why}" if knobs else why
    return scene | {"knobs": knobs, "notes": [*scene["notes"], note]}


def _still(m: Mechanism) -> str:
    """What stands where widgets are not shown: the drawing."""
    words = (
        "<p>This is the start. It moves where widgets are shown: run <code>pip install anywidget</code> in "
        "the environment of JupyterLab (it may be another than that of the kernel), then start JupyterLab again.</p>"
    )
    return card(m.name or "mechanism", drawing(m), words)


class Kernel:
    """Motions for other parameters, one at a time in a thread; of wishes that wait only the latest is kept."""

    def __init__(self, m: Mechanism, t_end: float | None) -> None:
        self._mechanism, self._t_end = m, t_end
        self._frame = json.loads(json.dumps(geometry(m.model)))
        self._lock = threading.Lock()
        self._next: tuple[Any, Tree] | None = None
        self._dropped: set[int] = set()  # numbers of wishes that nobody waits for
        self._thread: threading.Thread | None = None

    def ask(self, send: Any, message: Tree) -> None:
        """Take a message of the page; answers go to send(message)."""
        with self._lock:
            if message.get("do") == "cancel":
                self._dropped.add(int(message["id"]))
                return
            if message.get("do") != "compute":
                return
            send({"id": message["id"]})  # heard
            if self._next is not None:
                self._next[0]({"id": self._next[1]["id"], **LATER})
            self._next = (send, message)
            if self._thread is None or not self._thread.is_alive():
                self._thread = threading.Thread(target=self._work, daemon=True)
                self._thread.start()

    def wait(self) -> None:
        """Until nothing is computed any more."""
        if self._thread is not None:
            self._thread.join()

    def _work(self) -> None:
        while True:
            with self._lock:
                task, self._next = self._next, None
                if task is None:
                    self._thread = None
                    return
            send, message = task
            answer = LATER if message["id"] in self._dropped else self._answer(message)
            self._dropped.discard(message["id"])
            send({"id": message["id"], **answer})

    def _answer(self, message: Tree) -> dict[str, Any]:
        end = message.get("t_end")
        asked = {str(name): float(value) for name, value in dict(message.get("parameters") or {}).items()}
        now = self._mechanism.parameters
        changes = {name: value for name, value in asked.items() if now.get(name) != value}
        try:
            m = self._mechanism.set(changes) if changes else self._mechanism
            result = m.simulate(self._t_end if end is None else float(end))
            return {"run": json.loads(scene_json(run_of(result, "", self._frame)))}
        except (ModelError, AssemblyError, ValueError, ArithmeticError) as error:
            return {"error": str(error)}


# ---------------------------------------------------------------- the widget
def module_text() -> str:
    """The viewer and what connects it with a notebook, as one ES module."""
    return viewer_text() + files("rattle.pages").joinpath("notebook.js").read_text(encoding="utf-8")


def widget_class(what: str) -> Any:
    """The class of the widget; anywidget is imported only when one is made.  Raises MissingPackage."""
    package("anywidget", what)
    return _class_of_views()


@functools.cache
def _class_of_views() -> Any:
    import anywidget
    import traitlets

    class MotionView(anywidget.AnyWidget):  # type: ignore[misc]  # of an untyped package
        """A motion that one can play, with sliders."""

        _esm = module_text()
        scene = traitlets.Unicode().tag(sync=True)
        by_kernel = traitlets.Bool().tag(sync=True)

        def __init__(self, scene: Tree, kernel: Kernel | None, still: str) -> None:
            self.still, self.kernel = still, kernel
            super().__init__(scene=scene_json(scene), by_kernel=kernel is not None)
            if kernel is not None:
                self.on_msg(lambda _, message, __: kernel.ask(self.send, message))

        def _repr_mimebundle_(self, **options: Any) -> Any:
            bundle = super()._repr_mimebundle_(**options)
            data = bundle[0] if isinstance(bundle, tuple) else bundle
            if data is not None:
                data["text/html"] = self.still
                data["text/plain"] = "a motion that moves in a notebook with widgets"
            return bundle

    return MotionView
