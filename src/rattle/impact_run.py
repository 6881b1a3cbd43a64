"""Runs with set-valued contacts: event-driven or Moreau-Jean, from a consistent start to a result."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from rattle import catalog, complementarity, impact, pythonlaw
from rattle.complementarity import BACKWARD, FORWARD
from rattle.dynamics import CHUNK, Run, progress_bar, start_state
from rattle.equations import DONE, NOT_FINITE, OK, PAUSED, STEP_TOO_SMALL
from rattle.memory import Memory
from rattle.plane import IMPACT, NORMAL_P, OWNER
from rattle.steppers import event, march, moreau
from rattle.steppers.writing import record
from rattle.system import Compiled
from rattle.trouble import explain

STEPS = 20_000  # of Moreau-Jean over a run, when nothing is said


def has_impacts(ready: Compiled) -> bool:
    """True when the model has set-valued contacts."""
    return bool((ready.arrays["contact"][:, IMPACT] == 1).any())


def choose_method(ready: Compiled, method: str, step: float | None, span: float) -> tuple[str, float | None]:
    """Method and step for a model with set-valued contacts over a time [s].

    Methods that know no impact become "event".  Raises ValueError when impact and compliant contacts are mixed.
    """
    if not (ready.arrays["contact"][:, IMPACT] == 1).all():
        laws = {ready.joints[row[OWNER]]: "impact" if row[IMPACT] else "compliant" for row in ready.arrays["contact"]}
        listed = ", ".join(f"{name}: {law}" for name, law in laws.items())
        raise ValueError(f"impact and compliant contacts do not go together ({listed}); give all joints one kind")
    settings = ready.model.settings
    if method != "moreau" and settings.method == "moreau" and step == settings.step:
        step = None  # it was meant for the other method
    if method == "moreau":
        return method, step or min(1e-4, span / STEPS)
    return "event", step


def contact_arrays(ready: Compiled, lasting: bool) -> dict[str, Any]:
    """What set-valued contacts need besides the arrays of one instant; lasting: their forces are part of the motion."""
    nc, nr, nb = len(ready.arrays["contact"]), ready.row_count, ready.body_count
    held = np.array([1.0, ready.size])
    return {
        **{name: np.zeros(nc, np.int64) for name in ("mode", "chosen", "trial", "slide")},
        "pivot": np.zeros(2 * nc, np.int64),
        "arm": np.zeros((2 * nc, 6)),
        "direction": np.zeros((2 * nc, 3 * nb)),
        "reply": np.zeros((2 * nc, nr)),
        "delassus": np.zeros((2 * nc, 2 * nc)),
        "side": np.zeros((4, 2 * nc)),
        "system": np.zeros((2 * nc, 2 * nc + 1)),
        "held": held,
        "problem_table": catalog.entries(complementarity.KERNELS),
        **({"hold_table": catalog.entries([impact.hold])} if lasting else {}),
    }


class ImpactRun(Run):
    """A run of a model whose contacts are set-valued."""

    def prepare(self) -> Memory:
        """Memory of the run."""
        more = [event.happen] if self.method == "event" else []
        arrays = march.march_arrays(start_state(self.ready, self.start), len(self.ready.watched), *more)
        return self.ready.memory(**arrays, **contact_arrays(self.ready, self.method == "event"))

    def go(self, progress: bool = False, what: str = "simulate") -> None:
        """March to the end, or to where it cannot go on (then `message` says why)."""
        began = time.perf_counter()
        pythonlaw.forget()
        bar = progress_bar(self.t_end, what) if progress else None
        try:
            status = self._event(bar) if self.method == "event" else self._moreau(bar)
            if status != DONE:
                self.message = self._trouble(status)
        except KeyboardInterrupt:
            reached = self.clock[march.T]
            self.message = f"stopped by the user at t = {reached:.6g} s; the result holds what was computed before"
        finally:
            if bar is not None:
                bar.close()
            self.wall = time.perf_counter() - began

    def _take_events(self, bar: Any) -> None:
        m, tally = self.memory, self.tally
        self.contacts.append(m["events"][: tally[march.EVENT_COUNT]].copy())
        tally[march.EVENT_COUNT] = 0
        if bar is not None:
            bar.update(self.clock[march.T] - bar.n)

    def _event(self, bar: Any) -> int:
        m, tally = self.memory, self.tally
        h_max = self.step or math.inf
        self.stuck = np.array([-math.inf, 0.0, -1.0])
        self.clock[march.T] = self.start.t
        status = event.start(m.handle, self.start.t)
        if status == OK:
            status = march.begin(m.handle, self.start.t, self.t_end, self.rtol, self.atol, h_max)
        self.first_sign[:] = m["sign"]
        if status != OK:
            return int(status)
        if len(self.t_eval) and self.t_eval[0] <= self.start.t:
            record(m.handle, self.start.t, m["y"], self.raw[0])
            tally[march.OUTPUTS] = 1
        status = PAUSED
        while status == PAUSED:
            status = event.advance(
                m.handle, self.t_end, self.rtol, self.atol, h_max, self.t_eval, self.raw,
                CHUNK if catalog.jit_runs() else 20, self.stuck,
            )  # fmt: skip
            self._take_events(bar)
        return int(status)

    def _moreau(self, bar: Any) -> int:
        m = self.memory
        count = max(1, math.ceil((self.t_end - self.start.t) / (self.step or self.t_end) * (1 - 1e-12)))
        h = (self.t_end - self.start.t) / count
        moreau.start(m.handle, self.start.t)
        status = PAUSED
        while status == PAUSED:
            chunk = CHUNK if catalog.jit_runs() else 20
            status = moreau.advance(m.handle, self.start.t, h, count, self.t_eval, self.raw, chunk)
            self._take_events(bar)
        return int(status)

    def _trouble(self, status: int) -> str:
        t = float(self.clock[march.T])
        names = ", ".join(self._closed()) or "the contacts"
        if status == impact.NO_SOLUTION:
            return (
                f"the contact problem at {names} has no solution at t = {t:.9g} s (Painleve: friction would have to jam"
                " the joint); less friction, or a compliant contact, goes on"
            )
        if status == impact.NOT_UNIQUE:
            return (
                f"the contact problem at {names} has several solutions at t = {t:.9g} s (Painleve: rigid bodies with"
                " this friction do not say which); less friction, a compliant contact or method moreau goes on"
            )
        sliding = (self.memory["mode"] == FORWARD) | (self.memory["mode"] == BACKWARD)
        rough = self.memory["values"][self.ready.arrays["contact"][:, NORMAL_P] + 2] > 0.0
        if status == impact.LOCKED or (status == STEP_TOO_SMALL and (sliding & rough).any()):
            return (
                f"friction locks {names} at t = {t:.9g} s: the normal force grows beyond all bounds (Painleve); less"
                " friction, or a compliant contact, goes on"
            )
        if status == impact.CHATTER:
            joint = self.ready.joints[self.ready.arrays["contact"][int(self.stuck[2]), OWNER]]
            return f"contacts change without end at t = {t:.9g} s, last at joint '{joint}'; method moreau goes on"
        if status == NOT_FINITE and self.method == "moreau":
            return f"the motion ran away at t = {t:.6g} s with the step of {self.step:.3g} s; try a smaller step"
        return explain(self.ready, self.memory, self.t_end, status)

    def _closed(self) -> list[str]:
        owner, mode = self.ready.arrays["contact"][:, OWNER], self.memory["mode"]
        touching = (mode != complementarity.OFF) | (self.memory["touch"][:, 0] < 1e-6 * self.ready.size)
        return [f"'{name}'" for name in dict.fromkeys(self.ready.joints[n] for n in owner[touching])]
