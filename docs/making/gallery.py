"""All shipped examples: a card of each, and a page with a picture, a curve, one number, the commands of the header."""

from __future__ import annotations

import re
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

import rattle as rt
from making import live
from making.runs import SHORTER, header, run
from making.text import paragraph, shell
from making.tree import module_with


def _first_impact(result: Any, joint: str) -> float:
    """Time of the first impact at a joint."""
    return float(next(one.t for one in result.events if one.joint == joint and one.kind == "impact"))


NUMBERS: dict[str, tuple[str, Callable[[Any], tuple[float, str]]]] = {
    "connecting_rod": ("Largest stress of the rod", lambda r: (r.strength("rod").peak, "Pa")),
    "balanced_arm": ("Angle of the arm in equilibrium", lambda r: (r["arm.angle"][0], "rad")),
    "belt_drive": ("Tension of the tight strand at the end", lambda r: (r["belt.tight"][-1], "N")),
    "cam_lift_off": (
        "Speed at which the follower lands",
        lambda r: (max(one.normal_speed for one in r.events), "m/s"),
    ),
    "chain": ("Largest angular speed of the last link", lambda r: (np.abs(r["b20.omega"]).max(), "rad/s")),
    "crank_rocker_play": ("Least force between pin and bush at A", lambda r: (r["A.normal"].min(), "N")),
    "ellipse": ("Radius of the circle", lambda r: (np.ptp(r["coupler.P.x"]) / 2, "m")),
    "door_closer": ("Speed at which the door meets its frame", lambda r: (r.events[0].normal_speed, "rad/s")),
    "door_hinge": ("Total rotation of the hatch", lambda r: (np.ptp(r["hatch.angle"]), "rad")),
    "double_pendulum": ("Largest energy that nothing accounts for", lambda r: (r.trust.energy_balance, "J")),
    "dominoes": (
        "Time from the second stone to the last",
        lambda r: (_first_impact(r, "hit45") - _first_impact(r, "hit12"), "s"),
    ),
    "drawer": ("Acceleration at the end", lambda r: (r["drawer.ax"][-1], "m/s^2")),
    "fourbar": ("Normal force at O4 at the start", lambda r: (r["O4.normal"][0], "N")),
    "gear_rattle": (
        "Speed of the last knock",
        lambda r: ([one.normal_speed for one in r.events if one.kind == "impact"][-1], "m/s"),
    ),
    "geneva": ("Angle of the wheel after two turns", lambda r: (np.ptp(r["wheel.angle"]), "rad")),
    "guide_play": ("Turns of the crank in 0.2 s", lambda r: (r["crank.angle"][-1] / (2 * np.pi), "")),
    "jansen_leg": ("Length of a step", lambda r: (np.ptp(r["shank.foot.x"]), "m")),
    "marble_run": (
        "Time at which it stops rolling",
        lambda r: (max(one.t for one in r.events if one.contact == "rolling"), "s"),
    ),
    "ratchet": ("Lift in three swings", lambda r: (r["load.y"][-1] - r["load.y"][0], "m")),
    "rimless_wheel": ("Least rate of a step at the end", lambda r: (np.abs(r["wheel.omega"][-200:]).min(), "rad/s")),
    "scissor_lift": ("Force of the cylinder at the start", lambda r: (r["cylinder.force"][0], "N")),
    "squeezer": ("Turns of the motor in 30 ms", lambda r: (r["k1.angle"][-1] / (2 * np.pi), "")),
    "step_ladder": ("Force of the cord at rest", lambda r: (r["cord.force"][-1], "N")),
    "stick_slip": (
        "Time from one slip to the next",
        lambda r: (np.diff([one.t for one in r.events if one.kind == "slip"])[-1], "s"),
    ),
    "toggle": ("Force at the jaw at the end", lambda r: (r["grip"][-1], "N")),
    "torque_converter": (
        "Speed of the shaft after ten turns of the crank",
        lambda r: (r["rotor.omega"][-1], "rad/s"),
    ),
    "torque_converter_epicyclic": (
        "Speed of the rotor after ten swings of the carrier",
        lambda r: (r["rotor.omega"][-1], "rad/s"),
    ),
    "windows": ("Corner p0.P.x at 10 s", lambda r: (r["p0.P.x"][-1], "m")),
    "woodpecker": ("Distance travelled downwards in 1 s", lambda r: (r["sleeve.y"][0] - r["sleeve.y"][-1], "m")),
}
CURVES = {"squeezer": "k1.angle", "balanced_arm": ""}  # where the header has no `rattle plot` with a name
INSTANT = {
    "chain": 0.4,
    "dominoes": 0.5,
    "door_closer": 0.2,
    "geneva": 0.09,
    "marble_run": 0.35,
    "rimless_wheel": 0.2,
    "scissor_lift": 0.4,
    "step_ladder": 0.04,
    "toggle_clamp": 0.3,
    "slider_crank": 0.09,
    "slider_crank_play": 0.09,
}  # share of the run that is drawn
PATHS = {
    "five_bar": "left_forearm.pen",
    "ellipse": "coupler.P",
    "jansen_leg": "shank.foot",
    "marble_run": "marble.C",
}  # the path of a point shows more than a curve
ORBITS = {"bouncing_pin": "O"}  # a single pin in its bush: its path shows more than a drawing
WIDE, HIGH, DOTS = 8.6, 2.9, 100  # inches, inches, dots per inch


GROOVED = {"belt", "cam", "flat-follower", "gear", "locking-disc", "rack", "ring", "roller", "slot"}
SUBJECTS: dict[str, Callable[[Any, str], bool]] = {  # by what the model and the commands of its header have
    "play": lambda model, _: any(_is_loose(one) for one in model.joints.values()),
    "impact": lambda model, _: bool(_contacts(model) & {"impact", "stop"}),
    "oil": lambda model, _: "lubricated" in _contacts(model),
    "friction": lambda model, _: any(_rubs(one) for one in model.joints.values()),
    "gears, cams, slots": lambda model, _: any(one.kind in GROOVED for one in model.joints.values()),
    "clutches, stops": lambda model, _: any(one.stop or one.kind == "clutch" for one in model.joints.values()),
    "contact anywhere": lambda model, _: any(one.kind == "surface" for one in model.joints.values()),
    "strength, heat, life": lambda _, text: bool(re.search(r"rattle (strength|heat|durability|fit) ", text)),
    "springs, motors": lambda model, _: any(
        "spring" in one.kind or one.kind in ("actuator", "motor") for one in model.loads.values()
    ),
    "equilibrium": lambda _, commands: "rattle equilibrium" in commands,
    "accuracy": lambda _, commands: "rattle accuracy" in commands or "rattle tolerance" in commands,
    "ideal joints": lambda model, _: not _contacts(model) - {"ideal"},
}


def pages(folder: Path) -> dict[str, str]:
    """The gallery and a page per example; their pictures are drawn into `folder`/pictures."""
    for name in ("pictures", "gallery"):
        (folder / name).mkdir(exist_ok=True)
    examples = {f"gallery/{name}": _example(folder, name) for name in rt.examples()}
    return {"gallery": _cards(folder), **examples}


def _is_loose(joint: Any) -> bool:
    """True if a pin, a block or a tooth can move a little against what holds it."""
    held = joint.contact is None or joint.contact.model == "ideal"
    return not held and (bool(joint.clearance) or joint.kind == "gear")


def _rubs(joint: Any) -> bool:
    """True if there is friction in a joint or its contact."""
    contact = joint.contact
    return bool(joint.friction or (contact and (contact.friction or contact.fields.get("friction"))))


def _contacts(model: Any) -> set[str]:
    """Names of the contact models in a mechanism, and "stop"."""
    joints = model.joints.values()
    return {one.contact.model for one in joints if one.contact} | {"stop" for one in joints if one.stop}


def subjects(name: str) -> list[str]:
    """What an example is about."""
    model, commands = rt.example(name).model, "\n".join(header(name).commands)
    return [subject for subject, has in SUBJECTS.items() if has(model, commands)]


def _cards(folder: Path) -> str:
    """A card per example, with its drawing; `_static/gallery.js` adds a search."""
    drawings = folder / "beside" / "drawings"
    drawings.mkdir(parents=True, exist_ok=True)
    cards = []
    for name in rt.examples():
        (drawings / f"{name}.svg").write_text(_drawing(name), encoding="utf-8")
        cards.append(
            f'<a class="example" href="generated/gallery/{name}.html" data-subjects="{";".join(subjects(name))}">'
            f'<img src="drawings/{name}.svg" alt="" loading="lazy" width="230" height="144">'
            f"<b>{escape(rt.example(name).name)}</b><code>{name}</code><span>{escape(in_short(name))}</span></a>"
        )
    lines = [f'<div class="examples" data-subjects="{";".join(SUBJECTS)}">', *cards, "</div>"]
    return "\n".join(["```{raw} html", *lines, '<script src="_static/gallery.js" defer></script>', "```", ""])


def in_short(name: str) -> str:
    """What an example is, in one sentence; without its name where it begins with it."""
    sentence = re.split(r"(?<=[.;])\s", header(name).intro.replace("`", ""), maxsplit=1)[0]
    words = sentence.partition(": ")[2] or sentence
    words = words[:1].upper() + words[1:].rstrip(".;")
    return words if words.endswith("?") else f"{words}."


def _drawing(name: str) -> str:
    result = run(name).result
    k = int(INSTANT.get(name, 0.0) * (len(result.t) - 1))
    return module_with("thumbnail", "ACROSS").thumbnail(result, k, PATHS.get(name, ""), name)


def _example(folder: Path, name: str) -> str:
    said = header(name)
    _draw(folder / "pictures" / f"{name}.png", name)
    shortened = f" The picture shows the first {SHORTER[name]}." if name in SHORTER else ""
    parts = [
        f"# {paragraph(rt.example(name).name)}",
        f"`{name}`: {paragraph(said.intro)}",
        f"![{name}: the mechanism to scale and a curve](../pictures/{name}.png)",
        f"*{paragraph(_number(name))}.*{shortened} Look at {paragraph(said.look)}",
        live.opened(name, "../../"),
        shell(said.commands),
        f"Source: {paragraph(said.source)}",
        "[All examples](../../gallery.md)",
    ]
    return "\n\n".join(parts).replace("](theory.md", "](../../theory.md") + "\n"


def curve_of(name: str) -> str:
    """The curve that the header of an example plots first."""
    words = [word for word in header(name).words_of("plot")[1:] if not word.startswith("-")]
    return CURVES.get(name, words[0] if words else "")


def _number(name: str) -> str:
    quantity = module_with("quantity", "readable").quantity
    one = run(name)
    if name in NUMBERS:
        words, measure = NUMBERS[name]
        return f"{words}: {quantity(*measure(one.result))}"
    if one.accuracy is not None:
        return f"Largest deviation of {one.accuracy.of}: {quantity(one.accuracy.worst.max(), one.accuracy.unit)}"
    curve = curve_of(name)
    value, when = one.result.peak(curve)
    return f"Largest magnitude of `{curve}`: {quantity(value, one.result.unit(curve))} at {quantity(when, 's')}"


# ---------------------------------------------------------------- pictures
def _draw(path: Path, name: str) -> None:
    from matplotlib.figure import Figure

    one, curve = run(name), curve_of(name)
    if name in ORBITS:
        one.result.plot_orbit(ORBITS[name]).savefig(path, dpi=0.8 * DOTS)
        return
    figure = Figure(figsize=(WIDE, HIGH), layout="constrained")
    left, *right = figure.subplots(1, 1 if not curve and one.accuracy is None else 2, squeeze=False).flat
    mechanism_to_scale(left, one.result, INSTANT.get(name, 0.0))
    if right and one.accuracy is not None:
        _band(right[0], one.accuracy)
    elif right and name in PATHS:
        _path(right[0], one.result, PATHS[name])
    elif right:
        _curve(right[0], one.result, curve)
    figure.savefig(path, dpi=DOTS)


def mechanism_to_scale(ax: Any, result: Any, share: float) -> None:
    """The mechanism to scale, in the colours of its animations."""
    sketch = module_with("draw_mechanism", "extent")
    stage = module_with("Scene", "draw_line").Scene(result, np.array([int(share * (len(result.t) - 1))]), 1.0)
    low, high = sketch.extent(stage)
    size = float(max(high - low)) or 1.0
    ax.set(aspect="equal", xlabel="m")
    module_with("tidy", "robust_limits").tidy(ax).grid(False)
    sketch.draw_mechanism(ax, stage._replace(size=size))
    ax.set(xlim=(low[0] - 0.12 * size, high[0] + 0.12 * size), ylim=(low[1] - 0.12 * size, high[1] + 0.12 * size))
    ax.locator_params(nbins=5)
    ax.tick_params(labelsize=8)


def _path(ax: Any, result: Any, point: str) -> None:
    module_with("plot_path", "plot_orbit").plot_path(result, point, ax=ax)
    ax.set_title("", loc="left")  # the name of the mechanism, which is the heading here
    ax.set_title(f"path of {point}", fontsize=9)
    ax.get_legend().remove()
    ax.tick_params(labelsize=8)


def _curve(ax: Any, result: Any, name: str) -> None:
    plot = module_with("robust_limits", "tidy")
    values = result[name]
    factor, unit = module_with("handy_unit").handy_unit(
        result.unit(name), float(np.abs(values[np.isfinite(values)]).max())
    )
    span, time = (1e3, "ms") if result.t[-1] < 0.1 else (1.0, "s")
    plot.tidy(ax).plot(span * result.t, factor * values, color=plot.BLUE, linewidth=1)
    ax.set(xlabel=f"t [{time}]", title=f"{name} [{unit}]" if unit else name)
    ax.title.set_fontsize(9)
    ax.tick_params(labelsize=8)


def _band(ax: Any, found: Any) -> None:
    plot = module_with("robust_limits", "tidy")
    factor, unit = module_with("handy_unit").handy_unit(found.unit, float(found.worst.max()))
    plot.tidy(ax).plot(found.t, factor * found.worst, color=plot.BLUE, linewidth=1, label="worst, first order")
    if np.isfinite(found.high).any():
        half = factor * (found.high - found.low) / 2
        ax.plot(found.t, half, color=plot.ORANGE, linewidth=1, linestyle="--", label="exact")
    ax.set(xlabel="t [s]", title=f"{found.of}: largest deviation by play [{unit}]", ylim=(0, None))
    ax.title.set_fontsize(9)
    ax.tick_params(labelsize=8)
    ax.legend(frameon=False, fontsize=8)
