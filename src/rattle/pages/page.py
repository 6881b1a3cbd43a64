"""Live pages: a mechanism as one HTML file that computes its motion while its parameters are turned."""

from __future__ import annotations

import base64
import json
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rattle.errors import TraceError
from rattle.exchange.measured import require_readable, sources_of
from rattle.mechanism import Mechanism
from rattle.pages.engine import engine_of_pages
from rattle.pages.live_model import FOLLOWS, LiveModel, live_model
from rattle.pages.measured_data import measured_in, packed_curve
from rattle.pages.packed import as_json, lettered
from rattle.pages.replay import write_page
from rattle.pages.scene import OF_GHOST, frame_of, run_of, scene_json
from rattle.pages.sweep_page import sweep_scene
from rattle.pages.thinning import shared_rows
from rattle.pages.viewer_text import joined, viewer_files
from rattle.pages.wishes import Wishes
from rattle.pages.words import ENGLISH, UNNAMED, words_in
from rattle.results.columns import geometry
from rattle.results.handy_units import written_units

WORKER = "live_worker.js"
REPLAYED = 101  # instants of the motion that a browser shows which cannot compute
EXPORT = re.compile(r"^export \{.*\};\n|^export ", re.MULTILINE)


def page(
    m: Mechanism, path: str | os.PathLike[str], *, t_end: float | None = None,
    over: Mapping[str, Sequence[float | str]] | None = None, progress: bool = False, title: str = "",
    curves: Sequence[str] = (), trust: bool = True, language: str = ENGLISH,
    measured: str | Path | Iterable[str | Path] = (),
) -> str:  # fmt: skip
    """Write the page of a mechanism; returns why it replays runs that were computed before, "" if it computes.

    t_end: of the motion at first [s], instead of the model's.  over: values of parameters whose runs a page holds that
    cannot compute, see `sweep_page.runs_of`.  title, curves, trust, language, measured: as of `Mechanism.page`.  Raises
    ModelError, AssemblyError, InputError, OSError.
    """
    words_in(language)  # it is refused before anything runs, as files are that cannot be read
    measured = sources_of(measured)
    require_readable(measured)
    scene, why = None, "these values were asked for"
    if over is None:
        try:
            scene = live_scene(m, t_end)
            why = ""
        except TraceError as error:
            why = str(error).replace("straight-line code", "a page")
    if scene is None or why:
        scene = sweep_scene(m, why, t_end=t_end, over=over, progress=progress)
    dots = measured_in(scene, measured, curves)
    beside = {"measured": [packed_curve(curve)._asdict() for curve in dots]} if dots else {}
    first = [*dict.fromkeys((*curves, *(curve.curve for curve in dots)))] if curves else []
    write_page(Wishes(title, first, trust, language).of({**scene, **beside}), path)
    return why


def live_scene(m: Mechanism, t_end: float | None = None) -> dict[str, Any]:
    """The scene of a live page, without a run: the page computes it.

    t_end: of the motion at first [s], instead of the model's.  Raises TraceError, with the reason, for a mechanism
    whose motion cannot be computed in a page; ModelError, AssemblyError.
    """
    live = live_model(m, t_end)
    drawing = json.loads(json.dumps(geometry(m.model)))
    return {
        **frame_of(drawing),
        "title": m.name or UNNAMED,
        "geometry": drawing,
        "units": written_units(m.to_json()),
        "runs": [],
        "ideal": None,
        "knobs": knobs(m, live),
        "live": {
            "packed": lettered(worker_text(live)), "settings": {"t_end": live.t_end},
            "ideal": live.ideal is not None, "model": m.to_toml(), "names": list(live.names),
            "units": [live.data["result"]["units"][name] for name in live.names],
            "replay": lettered(scene_json(_replay(m, t_end))),
        },
        "show": {"ghost": live.ideal is not None},
        "notes": [*live.notes, *_fixed(live)],
    }  # fmt: skip


def _replay(m: Mechanism, t_end: float | None) -> dict[str, Any]:
    """The motion of the bodies as it was computed now, for browsers that cannot compute it."""
    result = m.simulate(t_end)
    if result.interrupted:
        raise KeyboardInterrupt
    rows = shared_rows(result, REPLAYED)
    return run_of(result, "", result.geometry, OF_GHOST, kept=(rows, {}))


def knobs(m: Mechanism, live: LiveModel) -> list[dict[str, Any]]:
    """The parameters that a page can change [SI], and the unit in which the model file writes each."""
    return [
        {
            "name": name, "value": parameter.value, "unit": parameter.unit, "min": parameter.minimum,
            "max": parameter.maximum, **words_of(m, name), "shown": m.written_unit(name)[1],
        }
        for name, parameter in live.parameters.items()
    ]  # fmt: skip


def words_of(m: Mechanism, name: str) -> dict[str, str]:
    """What a page calls a parameter, and what it says of it."""
    parameter = m.model.parameters[name]
    return {"label": parameter.label or name, "description": parameter.description}


def _fixed(live: LiveModel) -> list[str]:
    """What a reader must know of parameters that stay as they are."""
    groups: dict[str, list[str]] = {}
    for name, why in live.fixed.items():
        if why != FOLLOWS:
            groups.setdefault(why, []).append(name)
    return [f"not to be changed here: {', '.join(names)} ({why})" for why, names in groups.items()]


def worker_text(live: LiveModel) -> str:
    """The program of the page's worker: the engine, the recorded functions, and the numbers of their models."""
    models = {"model": live.data}
    if live.ideal is not None:  # what is alike is in the results: one after the other compression sees both
        models["ideal"] = {"result": live.ideal.data["result"], **live.ideal.data}
    return (
        f'"use strict";\n(() => {{\n{in_function(joined(viewer_files(), WORKER))}'
        f'const engineText = "{engine_in_text(live.contacts)}";\nconst models = {as_json(models)};\n'
        f"const begin = (port) => serve(port, engineText, {as_json(live.tape.written())}, models);\n"
        'if (typeof document === "undefined") begin(self);\nelse globalThis.rattleLive = begin;\n})();\n'
    )


def model_text(live: LiveModel) -> str:
    """An expression: the data of a model, and the tape with its functions."""
    return as_json({"data": live.data, "tape": live.tape.written()})


def engine_in_text(contacts: bool) -> str:
    """The engine with or without contacts in letters, see `bytesFrom` of viewer/core.js."""
    return base64.b64encode(engine_of_pages(contacts)).decode("ascii")


def in_function(module: str) -> str:
    """The text of a module as the inside of a function."""
    return EXPORT.sub("", module)
