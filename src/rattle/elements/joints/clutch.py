"""One-way clutch: body A drives body B in one sense of rotation; no rows, its torque is that of a contact.

s = sense (1 or -1),  w = s (w_B - w_A)  rate at which B overruns A,  tau = torque s tau on B and -s tau on A

ideal        0 <= tau  _|_  w >= 0                     velocity level: no gap, no memory; nothing is lost, tau w = 0
             with max_torque M:  0 <= tau <= M,  tau = 0 where w > 0,  tau = M where w < 0 (it slips and loses -M w)
viscous      tau = c max(0, -w)                        loses tau^2/c
compliant    x' = -w,  tau = k x + c x'                while it is engaged: from w < 0 on, x = 0, until tau falls to 0;
                                                       what is then left of k x^2/2 is lost
ratchet      0 <= tau  _|_  g >= 0                     position level: g = k p + s (phi_B - phi_A), pitch
             p = 2 pi/teeth; the integer k falls by one where g reaches p: the pawl drops behind the next tooth

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), one-way clutches as unilateral
constraints of the relative velocity.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from rattle.interfaces.contacts import OwnContact
from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import JointKind
from rattle.jit.functions import kernel
from rattle.language.recorded import bare, is_whole
from rattle.registry import Field, kind

MODELS = ("ideal", "viscous", "compliant", "ratchet")
IDEAL, VISCOUS, COMPLIANT, RATCHET = range(4)
NEEDS = {VISCOUS: ("damping",), COMPLIANT: ("stiffness",), RATCHET: ("teeth",)}
MAY_HAVE = {IDEAL: ("max_torque",), COMPLIANT: ("damping",)}


@kernel("joint")
def no_rows(body, a, b, p, k, row, rows):
    """A clutch has no constraint rows."""


@kind("joint", "clutch", no_rows)
class Clutch(JointKind):
    """One-way clutch: the first body drives the second in one sense, which may run faster.

    Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), one-way clutches.
    """

    rows = ()
    moment = True
    bodies = True
    places = False
    events = {"contact": "lock", "release": "free"}
    drawn_as = "clutch"
    model = Field(
        "", "set-valued (ideal), with oil (viscous), wound up like a spring (compliant) or with teeth (ratchet)",
        default="ideal", shape="choice", choices=MODELS,
    )  # fmt: skip
    sense = Field("", "1 drives counter-clockwise, -1 clockwise", default=1.0)
    damping = Field("N*m*s/rad", "torque per rate at which the driving body gets ahead", default=0.0, least="positive")
    stiffness = Field("N*m/rad", "torque per wind-up of the compliant model", default=0.0, least="positive")
    teeth = Field("", "number of teeth of the ratchet", default=0.0, least="positive")
    max_torque = Field("N*m", "torque at which an ideal clutch slips", default=math.inf, least="positive")

    @staticmethod
    def faults(written: Mapping[str, object], fields: Fields) -> Iterator[tuple[str, str]]:
        """Keys and what is wrong with them: a sense, a missing key, keys of other models."""
        if fields["sense"] not in (1.0, -1.0) and not math.isnan(fields["sense"]):
            yield "sense", f"expected 1 (counter-clockwise) or -1 (clockwise), got {fields['sense']:g}"
        if math.isnan(fields["model"]):
            return
        model = int(fields["model"])
        used = (*NEEDS.get(model, ()), *MAY_HAVE.get(model, ()))
        for key in NEEDS.get(model, ()):
            if key not in written:
                yield "", f'a clutch with model = "{MODELS[model]}" needs {key}'
        for key in ("damping", "stiffness", "teeth", "max_torque"):
            if key in written and key not in used:
                suited = " or ".join(
                    f'"{name}"' for n, name in enumerate(MODELS) if key in (*NEEDS.get(n, ()), *MAY_HAVE.get(n, ()))
                )
                yield key, f'model = "{MODELS[model]}" has no {key}; leave it out, or take model = {suited}'
        if model == RATCHET and not math.isnan(bare(fields["teeth"])) and not is_whole(fields["teeth"]):
            yield "teeth", f"expected a whole number of teeth, got {fields['teeth']:g}"

    @staticmethod
    def own_contact(fields: Fields) -> OwnContact:
        """The contact whose force is the torque of the clutch [N*m]."""
        model, sense = int(fields["model"]), fields["sense"]
        law = (fields["max_torque"], fields["stiffness"], fields["damping"])
        if model == RATCHET:
            pitch = 2.0 * math.pi / fields["teeth"]
            return OwnContact("ratchet", True, False, True, 0, int(sense), (sense, pitch, 0.0), law)
        rigid, states = model == IDEAL, 1 if model == COMPLIANT else 0
        return OwnContact("overrunning", rigid, True, False, states, int(sense), (sense,), law)
