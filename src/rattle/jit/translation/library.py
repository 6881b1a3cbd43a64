"""What functions of `math`, NumPy and Python are in LLVM's language.

Those written here in Python are translated like functions of the user.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.value_types import Plain

# functions of the C library, by name; those of NumPy round otherwise in the last digit now and then
LIBRARY: dict[object, str] = {
    getattr(math, name): name
    for name in (
        "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp",
        "exp2", "expm1", "log", "log1p", "log2", "log10", "pow", "hypot", "cbrt", "fmod", "erf", "erfc",
    )
    if hasattr(math, name)
} | {
    getattr(np, name): {"arc": "a"}.get(name[:3], name[:3]) + name[3:]
    for name in (
        "sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "sinh", "cosh", "tanh", "arcsinh", "arccosh",
        "arctanh", "exp", "exp2", "expm1", "log", "log1p", "log2", "log10", "hypot", "cbrt", "fmod",
    )
}  # fmt: skip
# LLVM's own, which every processor computes alike
INTRINSIC: dict[object, str] = {
    math.sqrt: "sqrt", math.fabs: "fabs", math.copysign: "copysign", math.floor: "floor", math.ceil: "ceil",
    math.trunc: "trunc", np.sqrt: "sqrt", np.fabs: "fabs", np.copysign: "copysign", np.floor: "floor",
    np.ceil: "ceil", np.trunc: "trunc", np.rint: "rint", round: "rint",
}  # fmt: skip
WHOLE = (math.floor, math.ceil, math.trunc, round)  # of these the result is an integer
WITH_TWO = ("atan2", "pow", "hypot", "copysign", "fmod")
CONVERSIONS = {int: "i", float: "f", bool: "b", np.float64: "f", np.int64: "i", np.bool_: "b"}
ABSOLUTE = (abs, np.abs)
EXTREMES: dict[object, str] = {min: "lt", max: "gt", np.min: "lt", np.max: "gt"}


def _sign(x):
    if x > 0:
        return 1
    return -1 if x < 0 else x * 0


def _minimum(a, b):
    return a if a < b or a != a else b


def _maximum(a, b):
    return a if a > b or a != a else b


def _clip(x, low, high):
    return _minimum(_maximum(x, low), high)


def _where(condition, yes, no):
    return yes if condition else no


def _power(x, y):
    return x**y


def _remainder(x, y):
    return x % y


def _quotient(x, y):
    return x // y


def _square(x):
    return x * x


def _radians(x):
    return x * (math.pi / 180.0)


def _degrees(x):
    return x * (180.0 / math.pi)


def _isnan(x):
    return x != x


def _isinf(x):
    return abs(x) == math.inf


def _isfinite(x):
    return abs(x) < math.inf


def _both(x, y):
    return bool(x) and bool(y)


def _either(x, y):
    return bool(x) or bool(y)


def _heaviside(x, middle):
    if x != x:
        return x
    return middle if x == 0.0 else float(x > 0.0)


def _total(values):
    total = 0
    for value in values:
        total += value
    return total


def _smallest(values):
    smallest = values[0]
    for value in values:
        if value < smallest:
            smallest = value
    return smallest


def _largest(values):
    largest = values[0]
    for value in values:
        if value > largest:
            largest = value
    return largest


def _interp(x, places, values):
    last = len(places) - 1
    if x != x:
        return x
    if x > places[last]:
        return float(values[last])
    if x < places[0]:
        return float(values[0])
    low, high = 0, last + 1
    while high - low > 1:
        middle = (low + high) // 2
        if places[middle] <= x:
            low = middle
        else:
            high = middle
    if low == last or places[low] == x:
        return float(values[low])
    return (values[low + 1] - values[low]) / (places[low + 1] - places[low]) * (x - places[low]) + values[low]


def _logarithm(x, base):
    return math.log(x) / math.log(base)


WRITTEN: dict[object, Plain] = {
    np.sign: _sign, np.minimum: _minimum, np.maximum: _maximum, np.clip: _clip, np.where: _where, np.power: _power,
    np.mod: _remainder, np.floor_divide: _quotient, np.square: _square, np.radians: _radians, np.deg2rad: _radians,
    np.degrees: _degrees, np.rad2deg: _degrees, math.radians: _radians, math.degrees: _degrees, np.isnan: _isnan,
    math.isnan: _isnan, np.isinf: _isinf, math.isinf: _isinf, np.isfinite: _isfinite, math.isfinite: _isfinite,
    np.logical_and: _both, np.logical_or: _either, np.heaviside: _heaviside, np.sum: _total, sum: _total,
    np.interp: _interp, pow: _power,
}  # fmt: skip
