"""Check of contact laws written by the user on random paths: does a law pull, or create energy?

Starting unloaded, the energy that was put into a contact can never be negative, whatever the path:

    W(t) = integral of F ddelta dt >= 0      and for friction      W(t) = integral of T u dt >= 0,  z(0) = 0

which is passivity (Willems, Dissipative dynamical systems, Arch. Rational Mech. Anal. 45 (1972) 321-351).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rattle import registry
from rattle.description.model import Choice, Contact, Model
from rattle.elements.custom.contact_law import ContactLaw
from rattle.interfaces.laws import FrictionLaw

PATHS = 40
POINTS = 400  # of a path
PULLS = 1e-9  # share of the largest force of a path below which a pull is rounding
SLIP = 1e-3  # about what is slipped along a path [m]
ALLOWED = 2e-3  # share of the work exchanged: error of the quadrature
_known: dict[object, str] = {}


def law_faults(model: Model) -> list[str]:
    """Faults of the user's laws of a model in words, joint by joint; empty if there are none."""
    faults = []
    for name, contact in ((name, contact) for name, joint in model.joints.items() for contact in joint.contacts):
        if contact.normal is None:
            continue
        laws = (("normal", contact.normal), ("friction", contact.friction))
        for family, choice in laws:
            if choice is not None and isinstance(registry.law(family, choice.kind).kernel, ContactLaw):
                fault = _fault(family, choice, contact)
                if fault:
                    faults.append(f"{name}: {family} law '{choice.kind}' {fault}")
    return faults


def _fault(family: str, choice: Choice, contact: Contact) -> str:
    kind = registry.law(family, choice.kind)
    key = (kind.kernel, tuple(choice.values.items()), repr(contact.static) if family == "normal" else "")
    if key not in _known:
        p, leaf = np.array([*kind.leaf.pack(choice.values), 0.0]), kind.leaf
        if issubclass(leaf, FrictionLaw):
            _known[key] = friction_fault(kind.kernel, p, leaf.states)
        else:
            _known[key] = normal_fault(kind.kernel, p, contact)
    return _known[key]


def normal_fault(kernel: Any, p: np.ndarray, contact: Contact) -> str:
    """Fault of a normal law with the stiffness of a contact, in words; "" if there is none.

    p: (n,) parameters of the law's kernel [SI].
    """
    assert contact.static is not None
    stiffness = registry.kinds("stiffness")[contact.static.kind]
    static: Any = stiffness.kernel
    q = np.array([*stiffness.leaf.pack(contact.static.values), 0.0])
    rng = np.random.default_rng(7)
    s = np.linspace(0.0, 1.0, POINTS + 1)
    for _ in range(PATHS):
        shape = np.sin(np.pi * s) * (1.0 + 0.4 * sum(rng.uniform(-1, 1) * np.sin(k * np.pi * s) for k in (1, 2, 3)))
        depth, v0 = 10.0 ** rng.uniform(-7, -4), 10.0 ** rng.uniform(-2, 1)
        delta = depth * np.maximum(shape, 0.0)
        duration = depth * (shape[1] - shape[0]) * POINTS / v0
        middle, step = 0.5 * (delta[1:] + delta[:-1]), np.diff(delta)
        rate = step * POINTS / duration
        force = np.array(
            [kernel(static(float(d), q, 0), float(d), float(r), v0, p, 0) for d, r in zip(middle, rate, strict=True)]
        )
        if not np.isfinite(force).all():
            return f"has no finite value (penetration {middle[~np.isfinite(force)][0]:.3g} m, approach at {v0:.3g} m/s)"
        raw = getattr(kernel, "law", None)
        if raw is not None:
            least = _least(raw, kernel, static, p, q, middle, rate, v0)
            if least[0] < -PULLS * float(force.max()):
                return f"pulls during the approach: {least[0]:.3g} N at a penetration of {least[1]:.3g} m"
        fault = _given_back(force * step)
        if fault:
            return f"creates energy: {fault}, in a contact {depth * 1e3:.2g} mm deep from {v0:.2g} m/s"
    return ""


def _least(law: Any, kernel: Any, static: Any, p: np.ndarray, q: np.ndarray, deep: Any, rate: Any, v0: float) -> Any:
    """Smallest force [N] of the user's function during the approach, and the penetration [m] there."""
    values = kernel.pack(*p[: len(kernel.pack._fields)])
    going = [(float(d), float(r)) for d, r in zip(deep, rate, strict=True) if r >= 0.0][:: max(1, POINTS // 40)]
    forces = [(float(law(static(d, q, 0), d, r, v0, values)), d) for d, r in going]
    return min(forces, default=(0.0, 0.0))


def friction_fault(kernel: Any, p: np.ndarray, states: int) -> str:
    """Fault of a friction law with so many states, in words; "" if there is none.

    p: (n,) parameters of the law's kernel [SI].
    """
    rng = np.random.default_rng(8)
    s = np.linspace(0.0, 1.0, POINTS + 1)
    dz = np.zeros(states)
    for _ in range(PATHS):
        wave = sum(rng.uniform(-1, 1) * np.sin(2 * np.pi * (k * s + rng.uniform())) for k in (1, 2, 3))
        speed, press = 10.0 ** rng.uniform(-4, 0.5), 10.0 ** rng.uniform(0, 4)
        u = speed * (wave + rng.uniform(-0.3, 0.3))
        swing = np.sin(2 * np.pi * (s * rng.integers(1, 4) + rng.uniform()))
        normal = press * (1.0 + 0.8 * swing)
        h = SLIP / speed / POINTS
        z, powers = np.zeros_like(dz), np.zeros(POINTS + 1)
        for k in range(POINTS + 1):
            powers[k] = kernel(float(u[k]), float(normal[k]), z, p, 0, dz) * u[k]
            if k < POINTS:
                first = dz.copy()
                kernel(float(u[k + 1]), float(normal[k + 1]), z + h * first, p, 0, dz)
                z += 0.5 * h * (first + dz)
        if not np.isfinite(powers).all():
            return "has no finite value"
        fault = _given_back(0.5 * h * (powers[1:] + powers[:-1]))
        if fault:
            return f"creates energy: {fault}, sliding at up to {np.abs(u).max():.2g} m/s under {press:.2g} N"
    return ""


def _given_back(work: np.ndarray) -> str:
    """In words, the energy [J] that came out beyond what was put in, at any time; "" if there is none."""
    moved, least = float(np.abs(work).sum()), float(np.cumsum(work).min())
    if not math.isfinite(least) or least >= -ALLOWED * moved:
        return ""
    return f"{-least:.2g} J more comes out than was put in, of {moved:.2g} J exchanged"
