"""The ways of heat from joints to the air and between them: as they are given, and as a matrix of conductances."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.description.model import HeatPaths
from rattle.errors import InputError, ModelError, Problem, WrongType, suggest
from rattle.language.quantities import Quantity, in_si
from rattle.mechanism import Mechanism

Array = NDArray[np.float64]
COLDEST_AIR = 73.15  # [K] -200 degC: a number below it is one in degC, no machine stands in such air
LIKE_COOLING, LIKE_CONDUCTION = '"pin=2 W/K, slider=1 W/K"', '"pin,slider=0.5 W/K"'
_PAIR = re.compile(r"\s*([^=,;]+),\s*([^=,;]+)=\s*([^=,;]+)(?:[,;]|$)")
Cooling = Mapping[str, Quantity] | str | None
Conduction = Mapping[tuple[str, str], Quantity] | str | None


class Network(NamedTuple):
    """Joints, and conductances between them and to the air: G (T - T_air) = P."""

    joints: tuple[str, ...]
    ambient: float  # [K]
    conductance: Array  # (n, n) G [W/K]
    cooled: NDArray[np.bool_]  # (n,) a way leads to the air, over other joints too

    def temperatures(self, loss: Array, slope: Array, at: Array) -> Array:
        """(n,) temperatures [K] at which the losses (n,) [W], with their slopes [W/K] from `at` (n,) [K], flow off.

        (G - diag s) (T - T_air) = P - s (T_0 - T_air); joints without a way to the air stay as warm as it.
        """
        k = np.flatnonzero(self.cooled)
        matrix = self.conductance[np.ix_(k, k)] - np.diag(slope[k])
        warm = np.full(len(self.joints), self.ambient)
        warm[k] += np.linalg.solve(matrix, loss[k] - slope[k] * (at[k] - self.ambient))
        return warm


def network(m: Mechanism, ambient: Quantity | None, cooling: Cooling, conduction: Conduction) -> Network:
    """The ways that are given, else those of the model.  Raises ModelError, InputError."""
    paths = _paths(m, ambient, cooling, conduction)
    assert paths.ambient is not None
    joints = tuple(m.model.joints)
    number = {name: k for k, name in enumerate(joints)}
    matrix = np.diag([paths.cooling.get(name, 0.0) for name in joints])
    cooled = matrix.diagonal() > 0.0
    for (a, b), conductance in paths.conduction.items():
        i, j = number[a], number[b]
        matrix[[i, j], [i, j]] += conductance
        matrix[[i, j], [j, i]] -= conductance
    for _ in joints:  # one way more in every round
        cooled = cooled | ((matrix != 0.0) & cooled).any(axis=1)
    return Network(joints, paths.ambient, matrix, cooled)


def _paths(m: Mechanism, ambient: Quantity | None, cooling: Cooling, conduction: Conduction) -> HeatPaths:
    paths = m.model.heat or HeatPaths()
    joints = m.model.joints
    if ambient is None and cooling is None and m.model.heat is None:
        words = 'where does its heat go? Write [heat] with ambient = "20 degC" and cooling = { joint = "2 W/K" }'
        raise ModelError([Problem(("heat",), words)])
    air = paths.ambient if ambient is None else _temperature(ambient)
    to_air = paths.cooling if cooling is None else _cooling(cooling, joints)
    between = paths.conduction if conduction is None else _conduction(conduction, joints)
    if air is None:
        raise InputError('ambient: how warm is the air? Give ambient="20 degC"')
    if not to_air:
        raise InputError("cooling: no way leads to the air; give the conductance of joints, {'pin': '2 W/K'}")
    return HeatPaths(_kelvin(air), to_air, between)


def _temperature(ambient: Quantity) -> float:
    if isinstance(ambient, bool):
        raise WrongType(f"ambient: expected a temperature, as in '20 degC'; got {ambient!r}")
    return in_si(ambient, "ambient", "K", "'20 degC'")


def _kelvin(air: float) -> float:
    if not air >= COLDEST_AIR:
        hint = f"; a number is kelvin, write '{air:g} degC'" if air > 0.0 else ""
        raise InputError(f"ambient: {air:g} K is no temperature of the air{hint}")
    return air


def _cooling(cooling: Mapping[str, Quantity] | str, joints: Collection[str]) -> dict[str, float]:
    if isinstance(cooling, str):
        parts = [part.partition("=") for part in re.split("[,;]", cooling) if part.strip()]
        if not all(equals for _, equals, _ in parts):
            raise InputError(f"cooling: expected {LIKE_COOLING}, got {cooling!r}")
        cooling = {name.strip(): value.strip() for name, _, value in parts}
    if not isinstance(cooling, Mapping):
        raise WrongType(f"cooling: expected conductances by joint, {{'pin': '2 W/K'}}; got {cooling!r:.60}")
    for name in cooling:
        _require_joint("cooling", name, joints)
    return {name: _conductance(f"cooling of {name}", value) for name, value in cooling.items()}


def _conduction(
    conduction: Mapping[tuple[str, str], Quantity] | str, joints: Collection[str]
) -> dict[tuple[str, str], float]:
    if isinstance(conduction, str):
        if _PAIR.sub("", conduction).strip():
            raise InputError(f"conduction: expected {LIKE_CONDUCTION}, got {conduction!r}")
        written = [((a.strip(), b.strip()), value.strip()) for a, b, value in _PAIR.findall(conduction)]
    elif isinstance(conduction, Mapping):
        written = list(conduction.items())
    else:
        raise WrongType(f"conduction: expected {{('a', 'b'): '0.5 W/K'}}; got {conduction!r:.60}")
    between: dict[tuple[str, str], float] = {}
    for pair, value in written:
        if not isinstance(pair, tuple) or len(pair) != 2 or pair[0] == pair[1]:
            raise InputError(f"conduction: expected two joints, as in ('a', 'b'); got {pair!r:.60}")
        for name in pair:
            _require_joint("conduction", name, joints)
        way = (min(pair), max(pair))
        between[way] = between.get(way, 0.0) + _conductance(f"conduction between {pair[0]} and {pair[1]}", value)
    return between


def _require_joint(what: str, name: str, joints: Collection[str]) -> None:
    if name not in joints:
        raise InputError(f"{what}: no joint {name!r:.60}{suggest(str(name), joints)}")


def _conductance(what: str, value: Quantity) -> float:
    if isinstance(value, bool):
        raise WrongType(f"{what}: expected a conductance, as in '2 W/K'; got {value!r}")
    conductance = in_si(value, what, "W/K", '"2 W/K"')
    if not 0.0 < conductance < np.inf:
        raise InputError(f"{what}: {value!r} must be positive; leave out a way that is not there")
    return conductance
