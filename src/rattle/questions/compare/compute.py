"""Comparison of all contact models of one mechanism: motion, joint force, orbit, events, energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle import registry
from rattle.analyses.elastic_bushes import LEAST_RESTITUTION, rigid_restitution
from rattle.description.switch_contact import recontact
from rattle.errors import AssemblyError, InputError, ModelError, Problem, suggest
from rattle.results.contact_summary import contact_lines, readable
from rattle.results.display import in_columns, quantity, table
from rattle.results.handy_units import handy_unit
from rattle.value_types import Tree

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.description.model import Joint
    from rattle.mechanism import Mechanism
    from rattle.results.result import Result
    from rattle.results.trust import Trust

IDEAL, LINK, IMPACT, COMPLIANT, OILED = "ideal", "massless link", "one-sided impact", "compliant", "lubricated"
DEFAULT_LAW, DEFAULT_RESTITUTION = "exact", 0.5
RADII = 10.0  # bush radius that is assumed if none is given, in clearances
POINTS = 4000  # output intervals
STILL = 1e-6  # [rad] a body that turns less does not turn: its angle moves by rounding and the drift of joints
OIL = "50 mPa*s"  # viscosity that is assumed if none is given: an oil ISO VG 46 at 40 degrees
BORE = 100.0  # bush radius around oil that is assumed if none is given, in clearances
CORNER = 1e9  # stiffness of a guide's corner that is assumed if none is given [N/m^1.5]


@dataclass(frozen=True, repr=False)
class Comparison:
    """Results of one mechanism by contact model; `str()` is a table, `figure()` a page of plots."""

    name: str
    results: Mapping[str, Result]  # model -> result
    skipped: Mapping[str, str]  # model -> why there is no result
    joint: str  # the joint that is shown
    curves: tuple[str, ...]  # motions that are shown
    assumed: tuple[str, ...]  # values that are not in the model file and were assumed

    @property
    def notes(self) -> dict[str, tuple[str, ...]]:
        """Notes by model: the message of a run that ended early, and the notes of its trust."""
        by_model = {
            model: (*([r.message] if r.message else []), *contact_lines(r), *r.trust.notes, *r.trust.coarse())
            for model, r in self.results.items()
        }
        return {model: notes for model, notes in by_model.items() if notes}

    def __repr__(self) -> str:
        return f"<rattle.Comparison: {self.name}, joint {self.joint}: {', '.join(self.results)}>"

    def _repr_html_(self) -> str:
        below = [f"{model}: {why}" for model, why in self.skipped.items()]
        return table(HEAD, self.rows(), f"{self.name}: joint {self.joint}", [*below, *self.assumed], "c.plot()")

    def __str__(self) -> str:
        lines = in_columns([HEAD, *self.rows()])
        lines += [f"{model}: left out: {why}" for model, why in self.skipped.items()]
        by_note: dict[str, list[str]] = {}
        for model, notes in self.notes.items():
            for note in notes:
                by_note.setdefault(note, []).append(model)
        lines += [f"{', '.join(models)}: {note}" for note, models in by_note.items()]
        return "\n".join([f"{self.name}: joint {self.joint}", *lines, *self.assumed])

    def rows(self) -> list[tuple[str, ...]]:
        """The table: one row per model, cells as in HEAD."""
        return [_row(model, result, self.joint) for model, result in self.results.items()]

    def record(self) -> dict[str, object]:
        """The table and its notes as plain data, in SI units."""
        models = {
            model: {
                **_numbers(model, result, self.joint), "success": result.success, "trust": result.trust.to_dict(),
                "notes": self.notes.get(model, ()),
            }
            for model, result in self.results.items()
        }  # fmt: skip
        return {"joint": self.joint, "models": models, "left_out": self.skipped, "assumed": self.assumed}

    @property
    def reference(self) -> str:
        """The model with which the others are compared: the ideal one if it can be assembled."""
        return IDEAL if IDEAL in self.results else next(iter(self.results))

    def plot(self) -> Figure:
        """The page of plots; the same as `figure`."""
        return self.figure()

    def figure(self) -> Figure:
        """The page of plots."""
        from rattle.questions.compare.pictures import page

        return page(self)


HEAD = ("model", "peak force", "RMS force", "pressing", "contacts", "impacts", "energy lost", "trusted up to")


NUMBERS = ("peak", "rms", "pressing", "contacts", "impacts", "hardest", "energy_lost")


def _numbers(model: str, result: Result, joint: str) -> dict[str, float | None]:
    """What a run says of a joint, by NUMBERS: forces [N], share of the time, counts, impulse [N*s], energy [J].

    A rigid contact has impulses, listed with the impacts; its force is that of lasting contact, where that can be read.
    None where there is nothing to say.
    """
    contact, force = result.contacts.get(joint), f"{joint}.force"
    numbers: dict[str, float | None] = dict.fromkeys(NUMBERS)
    if readable(result, force):
        numbers |= {"peak": max(result.peak(force)[0], contact.peak if contact else 0.0), "rms": result.rms(force)}
    if contact:
        numbers["pressing"] = contact.share
    if contact and model != LINK:
        oil = result.films.get(joint)  # its mean power has the dry friction beside it
        lost = oil.mean_power * float(result.t[-1] - result.t[0]) if oil else contact.energy_lost
        mine = [event for event in result.events if event.joint == joint and event.kind == "impact"]
        hardest = max((event.impulse for event in mine), default=0.0)
        numbers |= {"contacts": contact.contacts, "impacts": contact.impacts, "hardest": hardest, "energy_lost": lost}
    return numbers


def _row(model: str, result: Result, joint: str) -> tuple[str, ...]:
    numbers = _numbers(model, result, joint)

    def hits(count: float) -> str:
        return f"{count}, to {quantity(numbers['hardest'] or 0.0, 'N*s', 2)}" if count else "0"

    written: dict[str, Callable[[float], str]] = {
        "peak": newton, "rms": newton, "pressing": lambda share: f"{100 * share:.0f} %", "contacts": str,
        "impacts": hits, "energy_lost": lambda energy: quantity(energy, "J", 3),
    }  # fmt: skip
    cells = ["-" if (number := numbers[name]) is None else write(number) for name, write in written.items()]
    return (model, *cells, _reach(result.trust))


def _reach(trust: Trust) -> str:
    """How long a run can be trusted, and what of it cannot."""
    until = trust.trusted_until()
    reach = "-" if until is None else "the end" if until >= trust.t_end else quantity(until, "s", 3)
    pull = max(trust.pulled.values(), default=0.0)
    if pull > 0.0:
        return f"{reach} (pulls for {100.0 * pull:.2g} %)"
    return f"{reach} (not the peak)" if trust.unread or trust.coarse() else reach


def newton(force: float) -> str:
    """A force [N] as text, in N or kN."""
    return quantity(force, "N", usual=handy_unit("N", force))


def compare(
    m: Mechanism, *, joint: str | None = None, curve: str | Sequence[str] | None = None, t_end: float | None = None,
    law: str | None = None, progress: bool = False,
) -> Comparison:  # fmt: skip
    """Run a mechanism ideal, with massless links, with one-sided impact, with compliant contacts and with oil.

    joint: the joint to show (default: the first with clearance).  curve: the motion to show, or several (default:
    the angle or position of the last body).  t_end: duration [s] (default: one turn of the driver if it turns steadily,
    else what the model says).  law: the compliant law (default: that of the joint, else "exact").

    Values that a compliant contact needs and the model does not give are assumed, and listed in `.assumed`: a
    steel pin in a steel bush with a radius of 10 clearances, sphere in socket, restitution 0.5.  Oil goes into revolute
    joints, with the compliant contact beside it; 50 mPa s, a bush as long as wide with a radius of 100 clearances.
    Raises ModelError if no joint has clearance, or not the one to show, and ValueError for an unknown law.
    """
    from rattle.analyses.driver_period import driver_period

    loose = _joints_with_play(m, joint)
    if law is not None and law not in registry.kinds("normal"):
        raise InputError(f"law: no compliant law '{law}'{suggest(str(law), registry.kinds('normal'))}")
    end = t_end if t_end is not None else min(driver_period(m.system) or math.inf, m.model.settings.t_end)
    compliant, assumed = _compliant(m, loose, law)
    models: dict[str, Callable[[], Mechanism]] = {
        IDEAL: m.ideal,
        LINK: lambda: m.with_contact("massless-link"),
        IMPACT: lambda: m.with_contact("impact"),
        COMPLIANT: lambda: compliant,
    }
    if any(m.model.joints[name].play.holds_oil for name in loose):
        models[OILED] = lambda: _oiled(m, compliant, loose, assumed)
    results, skipped = _runs(models, end, progress)
    if COMPLIANT in results and (why := _too_soft(m, loose, results[COMPLIANT], assumed)):
        skipped[COMPLIANT] = why
        del results[COMPLIANT]
    first = next(iter(results.values()))
    shown = ((curve,) if isinstance(curve, str) else tuple(curve or ())) or (_motion(m, first),)
    for name in shown:
        _ = first.unit(name)  # raises UnknownName
    return Comparison(m.name or "mechanism", results, skipped, joint or loose[0], shown, tuple(assumed))


def _joints_with_play(m: Mechanism, shown: str | None) -> list[str]:
    """Joints with clearance.  Raises ModelError if there are none, or if the one that is to be shown has none."""
    loose = [name for name, joint in m.model.joints.items() if joint.clearance > 0.0]
    if not loose:
        raise ModelError([Problem((), "no joint has a clearance, so there is nothing to compare")])
    if shown is not None and shown not in loose:
        raise ModelError([Problem(("joints", shown), f"has no clearance{suggest(shown, loose)}")])
    return loose


def _runs(
    models: Mapping[str, Callable[[], Mechanism]], end: float, progress: bool
) -> tuple[dict[str, Result], dict[str, str]]:
    """Results to the time `end` [s] by model, and why others have none.  Raises AssemblyError if none has."""
    from rattle.analyses.dynamics.methods import contacts_of
    from rattle.solvers.stepper import usual_stepper

    times = np.linspace(0.0, end, POINTS + 1)
    results: dict[str, Result] = {}
    skipped: dict[str, str] = {}
    changed: list[str] = []  # what became of given start values, in the first model in which that matters
    for model, make in models.items():
        try:
            loosened = make()
            method = usual_stepper(contacts_of(loosened.system))
            results[model] = loosened.simulate(end, t_eval=times, method=method, horizon=True, progress=progress)
            changed += _say_once(results[model], loosened, changed)
            if results[model].cut_short:
                skipped.update(
                    dict.fromkeys([later for later in models if later not in results], "stopped by the user")
                )
                break
        except ModelError as error:
            skipped[model] = error.problems[0].message
        except AssemblyError as error:
            skipped[model] = str(error)
            if len(skipped) == len(models):
                raise
    return results, skipped


def _say_once(result: Result, model: Mechanism, before: list[str]) -> list[str]:
    """What became of the start values of a model; left out of its result if the same was said of another one."""
    changed = [note for note in model.start.notes if note not in model.model.remarks]
    if before:
        result.trust = replace(result.trust, notes=tuple(note for note in result.trust.notes if note not in changed))
    return changed


def _too_soft(m: Mechanism, loose: list[str], r: Result, assumed: list[str]) -> str:
    """Why a compliant run with assumed bushes says nothing about this mechanism, in words; "" if it does."""
    if not any("bush radius" in assumption for assumption in assumed):
        return ""
    for name in loose:
        play = m.model.joints[name].clearance
        deep = r.peak(f"{name}.penetration")[0] if f"{name}.penetration" in r else 0.0
        if m.model.joints[name].play.from_materials and deep > play:
            return (
                f"the assumed bush, {RADII:g} clearances wide, is too small for these forces: the"
                f" pin of {name} sinks {quantity(deep, 'm', 3)} into it, more than its play of"
                f" {quantity(play, 'm', 3)}; give joints.{name}.contact a bush_radius and materials, or a stiffness"
            )
    return ""


def _motion(m: Mechanism, ideal: Result) -> str:
    """Name of the angle of the last body, or of its larger motion if it does not turn."""
    body = m.model.moving_bodies[-1]
    turned = ideal[f"{body}.angle"]
    if float(turned.max() - turned.min()) > STILL:
        return f"{body}.angle"
    return max((f"{body}.x", f"{body}.y"), key=lambda name: float(ideal[name].max() - ideal[name].min()))


def _compliant(m: Mechanism, loose: list[str], law: str | None) -> tuple[Mechanism, list[str]]:
    """The mechanism with compliant contacts, and the assumptions that were needed for them."""
    compliant = m
    assumed: dict[str, list[str]] = {}
    for name in loose:
        joint = m.model.joints[name]
        own = joint.contact.law if joint.contact else ""
        contact = recontact(m.contact_of(name), law or own or DEFAULT_LAW)
        written = {"model": contact} if isinstance(contact, str) else contact
        more, assumptions = _stiffness(joint, written)
        restitution = _restitution(joint, written)
        if restitution:
            more["restitution"] = restitution[0]
            assumptions.append(restitution[1])
        compliant = compliant.set({f"joints.{name}.contact": {**written, **more}})
        if assumptions:
            assumed.setdefault(", ".join(assumptions), []).append(name)
    return compliant, [f"assumed for the compliant {', '.join(names)}: {words}" for words, names in assumed.items()]


def _stiffness(joint: Joint, written: Tree) -> tuple[dict[str, Any], list[str]]:
    """Keys that a compliant contact needs for its stiffness and friction, and what is said of them."""
    more: dict[str, Any] = {}
    assumptions = []
    if not any(key == "stiffness" or key.endswith("material") for key in written) and not _bedded(written):
        if joint.play.from_materials:
            if written.get("bush_radius") is None:
                more["bush_radius"] = RADII * joint.clearance
                assumptions.append(f"bush radius {quantity(RADII * joint.clearance, 'm', 3)}")
            more |= {"bush_material": "steel", "pin_material": "steel"}
            assumptions.append("steel on steel, sphere in socket")
        else:
            more |= {"stiffness": CORNER, "exponent": 1.5}
            assumptions.append(f"stiffness of a contact {CORNER:.1e} N/m^1.5")
    if "friction" in written and "bush_radius" not in {**written, **more} and joint.play.has_radius:
        more["bush_radius"] = RADII * joint.clearance
    return more, assumptions


def _restitution(joint: Joint, written: Tree) -> tuple[float, str] | None:
    """The restitution that a compliant contact gets, and what is said of it; None if it needs none but its own."""
    fields = registry.kinds("normal")[written["model"]].fields
    if "damping" in written:
        return None
    if "restitution" not in written:
        needed = "restitution" in fields and fields["restitution"].default is registry.REQUIRED
        return (DEFAULT_RESTITUTION, f"restitution {DEFAULT_RESTITUTION:g}") if needed else None
    if joint.contact is None or not joint.contact.rigid:
        return None
    own = rigid_restitution(joint.contact.fields)
    if own >= LEAST_RESTITUTION:  # the same bushes as in the bracket of a rigid contact
        return None
    return LEAST_RESTITUTION, f"restitution {LEAST_RESTITUTION:g} in place of {own:g}"


def _bedded(written: Tree) -> bool:
    """True of a contact with a geometry whose stiffness needs no materials."""
    kind = registry.kinds("stiffness").get(str(written.get("geometry")))
    return kind is not None and "bush_material" not in kind.fields


def _oiled(m: Mechanism, compliant: Mechanism, loose: list[str], assumed: list[str]) -> Mechanism:
    """The mechanism with oil in every clearance that holds it, beside the compliant contact; adds to `assumed`."""
    changes: dict[str, Any] = {}
    by_words: dict[str, list[str]] = {}
    for name in loose:
        joint = m.model.joints[name]
        if joint.contact is not None and joint.contact.film is not None:
            changes[f"joints.{name}.contact"] = m.contact_of(name)
            continue
        if not joint.play.holds_oil:
            continue
        contact, assumptions = recontact(compliant.contact_of(name), "lubricated"), [f"oil of {OIL}"]
        assert isinstance(contact, dict), "a compliant contact is a table"
        if "bush_radius" not in m.contact_of(name):
            contact["bush_radius"] = bore = BORE * joint.clearance
            if bore > 0.5 * m.system.extent:
                play, radius = quantity(joint.clearance, "m", 3), quantity(bore, "m", 3)
                words = (
                    f"{name} has no bush_radius, and a usual one for {play} of play around oil, {radius}, does not fit"
                    " this mechanism; give bush_radius, length and viscosity"
                )
                raise ModelError([Problem(("joints", name), words)])
            assumptions.append(f"bush radius {quantity(BORE * joint.clearance, 'm', 3)}")
        if "length" not in contact:
            written = contact["bush_radius"]
            contact["length"] = 2.0 * written if isinstance(written, int | float) else f"2*({written})"
            assumptions.append("a bush as long as wide")
        changes[f"joints.{name}.contact"] = {"viscosity": OIL, **contact}
        if math.hypot(*m.model.initial.offsets.get(name, (0.0, 0.0))) > 0.9 * joint.clearance:
            changes[f"initial.{name}.offset"] = [0, 0]
            assumptions.append("it starts in the middle")
        by_words.setdefault(", ".join(assumptions), []).append(name)
    oiled = compliant.set(changes)
    assumed += [f"assumed for the lubricated {', '.join(names)}: {text}" for text, names in by_words.items()]
    return oiled
