"""Scenes: results as one JSON document that the viewer shows; docs/scene.md describes every key."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from rattle.drawings.forms import display_list, form_of, play_of
from rattle.errors import InputError
from rattle.pages.derived_curves import derived_curves
from rattle.pages.thinning import Between, Rows, between, shared_rows
from rattle.pages.words import UNNAMED
from rattle.plots.scene import BODIES
from rattle.results.contact_summary import contact_lines, far_apart
from rattle.results.handy_units import units_of_result
from rattle.results.result import Result
from rattle.results.trust import HOW
from rattle.results.within_steps import shown_curve, summit
from rattle.value_types import Tree
from rattle.version import __version__

FORMAT = "rattle-scene 1"
OF_GHOST = (".x", ".y", ".angle")
MOST_ROWS = 2501  # evenly chosen instants of a run in a page
ROWS_IN_ALL = 10_000  # of all runs of a page together, so that it can be sent
FEWEST_ROWS = 401  # of a run, however many there are
TOWERING = "curves are cut where they tower with the forces of rigid contacts, which says nothing of real ones"
TICKS = 2**32 - 1  # parts of a run in which the instants of single values are counted


def scene_of(
    results: Sequence[tuple[str, Result]], *, ideal: Result | None = None, title: str = "",
    show: Tree | None = None, notes: Iterable[str] = (),
) -> dict[str, Any]:  # fmt: skip
    """The scene of one or several results of a mechanism, each with a label; ready for JSON.

    ideal: a result of the same mechanism without play, the ghost.  show: what the viewer shows at first.
    Raises InputError without a result, or for one without motion of bodies.
    """
    if not results:
        raise InputError("a scene needs at least one result")
    for _, result in results:
        require_motion(result)
    first = results[0][1]
    most = max(FEWEST_ROWS, min(MOST_ROWS, ROWS_IN_ALL // len(results)))
    remarks, thinned = list(notes), ""
    runs = []
    for label, result in results:
        kept = shared_rows(result, most)
        more = between(result, kept)
        runs.append(run_of(result, label, first.geometry, kept=(kept, more)))
        if len(kept) < len(result.t):
            thinned = thinned or _thinned(result, kept, more)
    remarks += [thinned] if thinned else []
    remarks += [TOWERING] if any(result.trust.unread for _, result in results) else []
    scene: dict[str, Any] = plain({
        **frame_of(first.geometry),
        "title": title or str(first.provenance.get("model") or "") or UNNAMED,
        "geometry": first.geometry,
        "units": units_of_result(first.provenance),
        "runs": runs,
        "ideal": None if ideal is None else run_of(ideal, "without play", first.geometry, OF_GHOST),
        "knobs": [],
        "live": None,
        "show": dict(show or {}),
        "notes": remarks,
    })  # fmt: skip
    return scene


def _thinned(result: Result, kept: Rows, more: Mapping[str, Between]) -> str:
    """What a reader must know of a run of which a page holds a part."""
    text = f"shown are {len(kept)} of the {len(result.t)} instants of the result, and between them the values at which"
    text += " a curve turns: no largest or least value is lost; events keep their times"
    fast = [name for name, extra in more.items() if not extra.all_turns]
    if not fast:
        return text
    named = ", ".join(fast[:3]) + (f" and {len(fast) - 3} more" if len(fast) > 3 else "")
    return f"{text}. Too fast to be held as they are: {named}; of these the page has the range between two instants"


def frame_of(geometry: Tree) -> dict[str, Any]:
    """Those keys of a scene that follow from the geometry of a model alone, such as its drawing."""
    return {
        "format": FORMAT,
        "program": f"rattle {__version__}",
        "kinds": kinds_of(geometry),
        "drawing": display_list(geometry),
        "derived": derived_curves(geometry),
        "colours": {body: BODIES[k % len(BODIES)] for k, body in enumerate(geometry["bodies"])},
    }


def kinds_of(geometry: Tree) -> dict[str, dict[str, str]]:
    """How joints and loads are drawn, by name, and what the play of a joint looks like."""
    drawn: dict[str, dict[str, str]] = {"joints": {}, "loads": {}, "play": {}}
    for family in ("joint", "load"):
        for name, form in geometry[f"{family}s"].items():
            if how := form_of(family, form["type"]):
                drawn[f"{family}s"][name] = how
    for name, form in geometry["joints"].items():
        if play := play_of(form):
            drawn["play"][name] = play
    return drawn


def require_motion(result: Result) -> None:
    """Raise InputError if a result has no motion of bodies that could be shown."""
    if not result.geometry["bodies"]:
        raise InputError("this result holds curves only, no motion of bodies that could be shown")
    if not len(result.t):
        raise InputError("the result has no instant to show")


def run_of(
    result: Result, label: str, geometry: Tree, keys: Sequence[str] = (), *,
    kept: tuple[Rows, Mapping[str, Between]] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """One run of a scene; its geometry is left out where it is that of the scene.

    keys: of the curves that are kept, such as `.x`; all curves without any.  kept: rows of all curves, and what single
    curves keep between them.
    """
    if kept is None:
        shared = shared_rows(result, MOST_ROWS)
        kept = shared, {} if keys else between(result, shared)
    picked, more = kept
    names = [name for name in result.stored if not keys or name.endswith(tuple(keys))]
    data = np.column_stack([shown_curve(result, name)[picked] for name in names])
    run = {
        "label": label,
        "parameters": dict(result.provenance.get("parameters") or {}),
        "names": names,
        "units": [result.unit(name) for name in names],
        "n": len(picked),
        "t": packed(result.t[picked].astype("<f8")),
        "data": packed(_single(data.T)),
        "between": {name: _single_values(result, name, part.rows) for name, part in more.items()},
        "peaks": {} if keys else _peaks(result),
        "events": _events(result),
        "trust": trust_of(result),
        "success": result.success,
        "message": result.message,
    }
    if result.geometry == geometry:
        return run
    own = display_list(result.geometry)  # another one only where parts are there or not
    return run | {"geometry": result.geometry} | ({} if own == display_list(geometry) else {"drawing": own})


def _single(values: np.ndarray) -> np.ndarray:
    """Numbers in single precision."""
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(values).astype("<f4")


def _single_values(result: Result, name: str, rows: Rows) -> list[str]:
    """Instants, as shares of the run in `TICKS`, and values of one curve at some rows."""
    span = float(result.t[-1] - result.t[0]) or 1.0
    at = np.rint((result.t[rows] - result.t[0]) / span * TICKS).astype("<u4")
    return [packed(at), packed(_single(shown_curve(result, name)[rows]))]


def _events(result: Result) -> list[list[Any]]:
    """Events as lists; the largest force of a contact is nan where it says nothing of a real one."""
    unread = {name for name, summary in result.contacts.items() if not summary.readable}
    events = [event._replace(peak_force=math.nan) if event.joint in unread and event.peak_force else event
              for event in result.events]  # fmt: skip
    return [list(event) for event in events]


def trust_of(result: Result) -> dict[str, Any]:
    """What a page says about how far a run can be trusted, in the words of `rattle run`: numbers (SI) and lines."""
    trust, word = result.trust, result.trust.word.replace(HOW, "")
    return {
        "drift": trust.drift,
        "energy": trust.energy_balance,
        "energy_share": trust.energy_share,
        "pulled": dict(trust.pulled),
        "horizon": trust.horizon,
        "word": word,
        "limits": [word] if trust.excepts or trust.poor or far_apart(result) else [],
        "contacts": list(contact_lines(result)) if len(result.t) else [],
        "text": str(trust).replace(HOW, "").splitlines(),
    }


def packed(values: np.ndarray) -> str:
    """The bytes of an array as base64."""
    return base64.b64encode(values.tobytes()).decode("ascii")


def _peaks(result: Result) -> dict[str, list[float]]:
    """The largest magnitude of each curve within the steps of the run, and its time [s]."""
    summits = {name: summit(result, name) for name in result.peaks if name in result}
    return {name: [top.y, top.t] for name, top in summits.items() if top}


def plain(value: Any) -> Any:
    """A value with only what JSON knows: numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def scene_json(scene: Tree) -> str:
    """A scene as JSON that may stand inside of a script element of a page."""
    text = json.dumps(plain(scene), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
