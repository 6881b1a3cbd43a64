"""Two bodies on a smooth path, and possible values of fields: what contracts of kinds are tried on."""

import math
import zlib

import numpy as np

from rattle.interfaces.fields import absent
from rattle.language.expression import parse
from rattle.language.local_function import local_function
from rattle.language.tables import NO_TABLES

H = 1e-5  # step of central differences: error H**2 / 6 times third derivatives of order 10, rounding 1e-16 / H
FIRST, SECOND = 1e-8, 1e-4  # error allowed in first and (1e-16 / H**2) second differences
A, B = 1, 2


def rng_for(*words):
    return np.random.default_rng(zlib.crc32(" ".join(words).encode()))


SHARES = {  # of fields that have to be smaller than others
    "pressure_angle": 0.25, "backlash": 0.05, "pretension": 0.05, "play": 0.02, "rounding": 0.05,
}  # fmt: skip
COUNTS = {"arcs"}  # fields that are whole numbers
OPTIONS = {"roller"}  # fields that are also left out: 0 is another way

ONE_SIDED = {"tension_only"}  # flags that a kernel is told to be 1 where the load exerts nothing


def field_values(kind, rng):
    """One possible value of every field, in the order of the kernel; functions are yet to be packed."""
    found = {}
    for key, one in kind.fields.items():
        if one.function_of:
            shape = parse(f"{rng.uniform(0.5, 2.0)} + {rng.uniform(-0.5, 0.5)}*sin({one.function_of})**3")
            found[key] = [local_function(shape, one.function_of, {}, NO_TABLES)]
        elif (key in OPTIONS or one.default is absent) and rng.integers(2):
            found[key] = [0.0]
        elif key in COUNTS:
            found[key] = [float(rng.integers(3, 9))]
        elif one.shape == "number":
            found[key] = [rng.uniform(0.5, 2.0) * SHARES.get(key, 1.0)]
        elif one.shape == "triple":
            found[key] = list(rng.uniform(0.5, 2.0, 3))
        elif key in ONE_SIDED:
            found[key] = [0.0]
        elif one.shape == "pair":
            found[key] = list(rng.uniform(0.5, 2, 2) if one.least == "positive" else rng.uniform(-2, 2, 2))
        elif one.shape == "flag":
            found[key] = [float(rng.integers(2))]
        elif one.shape == "choice":
            found[key] = [float(rng.integers(len(one.choices)))]
        elif one.shape == "point":
            found[key] = list(rng.uniform(-1, 1, 2))
        elif one.shape == "connect":
            found[key] = list(rng.uniform(-1, 1, 4))
        else:
            assert one.shape in ("body", "labels"), f"tell the contracts how a {one.shape} is made"
            found[key] = []
    return [x for part in found.values() for x in part]


class Path:
    """A smooth motion of two bodies: q(t) with its exact rates, and a function of time f(t) for drivers."""

    def __init__(self, rng):
        self.q0 = rng.uniform(-2, 2, (3, 3))
        self.a = rng.uniform(-1, 1, (3, 3))
        self.w = rng.uniform(0.5, 2, (3, 3))
        self.q0[0] = self.a[0] = 0.0  # the ground

    def q(self, t):
        return self.q0 + self.a * np.sin(self.w * t)

    def v(self, t):
        return self.a * self.w * np.cos(self.w * t)

    def dv(self, t):
        return -self.a * self.w**2 * np.sin(self.w * t)

    @staticmethod
    def f(t):
        return [math.sin(1.3 * t), 1.3 * math.cos(1.3 * t), -1.69 * math.sin(1.3 * t)]


def turned(angle, point):
    """A vector turned by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1]])


def body_at(q, v):
    return np.ascontiguousarray(np.column_stack([q, v, np.cos(q[:, 2]), np.sin(q[:, 2])]))
