"""Calculator of journal bearings: force of an oil film, where a load comes to rest in it, stiffness, damping, whirl."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rattle import registry
from rattle.errors import InputError, ModelError, Problem, WrongType, suggest
from rattle.interfaces.laws import FilmLaw
from rattle.language.quantities import Quantity, in_si
from rattle.questions.film.journal import JournalPosition, located, position_at, threshold
from rattle.questions.film.locus import locus
from rattle.results.archive import package
from rattle.results.display import quantity, table
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from rattle.description.model import Joint
    from rattle.results.result import Result

Array = NDArray[np.float64]
THINNEST = 1e-6  # least film over the clearance: thinner ones act as this one
SHOWN = (0.01, 0.05, *(n / 20 for n in range(2, 20)), 0.97, 0.98, 0.99)  # eccentricities of a table
EXAMPLES = {  # argument -> SI unit, how it may be written
    "viscosity": ("Pa*s", '0.05 or "50 mPa*s"'),
    "length": ("m", '0.01 or "10 mm"'),
    "radius": ("m", '0.01 or "10 mm"'),
    "clearance": ("m", '5e-5 or "50 um"'),
    "load": ("N", '500 or "500 N"'),
    "speed": ("rad/s", '100 or "1000 rpm"'),
    "boundary_film": ("m", '1e-6 or "1 um"'),
    "stiffness": ("N/m", '5e8 or "5e8 N/m"'),
}


@answers_in_words
class Film:
    """An oil film between a pin (journal) and its bush, on its own: a calculator of journal bearings.

    Quantities are numbers in SI units or texts such as "50 mPa*s".  viscosity: dynamic, at the temperature of the film;
    length: of the bush; radius: of its bore; clearance: radial.  model: "finite" (a table of films of any length up to
    L/D = 2), "short" (closed form) or "pinkus-sternlicht" (long, to repeat papers).  cavitation: "reynolds" (no
    pressure below the surroundings) or "full" (of either sign).  shear: "whole" (the film drags on the whole
    circumference) or "wetted" (where it has pressure).

    Example:
        f = rt.Film("50 mPa*s", length="10 mm", radius="10 mm", clearance="50 um")
        p = f.static(load="500 N", speed="1000 rpm")
        p.eccentricity, p.film_thickness, p.stiffness

    Raises InputError and TypeError for values that make no bearing.
    """

    def __init__(
        self,
        viscosity: Quantity,
        length: Quantity,
        radius: Quantity,
        clearance: Quantity,
        model: str = "finite",
        cavitation: str = "reynolds",
        shear: str = "whole",
    ) -> None:
        self.viscosity = _positive("viscosity", viscosity)
        self.length = _positive("length", length)
        self.radius = _positive("radius", radius)
        self.clearance = _positive("clearance", clearance)
        self.model, self.cavitation, self.shear = model, cavitation, shear
        self._kind = _kind(model)
        chosen = {"cavitation": cavitation, "shear": shear}
        _check_words(self._kind, chosen)
        self._values: dict[str, Any] = {
            "viscosity": self.viscosity, "length": self.length, "bush_radius": self.radius, **chosen
        }  # fmt: skip
        faults = self._kind.leaf.faults(self._values, self.clearance)
        if faults:
            raise InputError("; ".join(faults))
        self._p = self._packed(THINNEST * self.clearance)
        self._table = np.array(self._kind.leaf.table(self._values))  # its own: compiled functions take no read-only one

    @classmethod
    def of_joint(cls, joint: Joint) -> Film:
        """The film of a joint with oil.  Raises ModelError for another one."""
        film = joint.contact.film if joint.contact is not None and joint.is_loose else None
        if film is None:
            needs = 'a clearance, and contact = { model = "lubricated", viscosity, length, bush_radius }'
            raise ModelError([Problem(("joints", joint.name, "contact"), f"a film needs oil in the joint: {needs}")])
        law = film.law
        words = {key: word for key, word in law.values.items() if isinstance(word, str)}
        sizes = (law.number("viscosity"), law.number("length"), law.number("bush_radius"))
        return cls(*sizes, joint.clearance, law.kind, **words)

    def _packed(self, least: float) -> Array:
        """Parameters of the kernel; least: thickness [m] below which a film acts as one that thick."""
        return np.array(self._kind.leaf.pack(self._values, self.clearance, least), dtype=float)

    def _repr_html_(self) -> str:
        rows = [
            ("viscosity", f"{1e3 * self.viscosity:.4g} mPa*s"), ("length", quantity(self.length, "m")),
            ("bush radius", quantity(self.radius, "m")), ("radial clearance", f"{1e6 * self.clearance:.4g} um"),
            ("length over diameter", f"{self.ratio:.3g}"), ("model", f"{self.model}, cavitation {self.cavitation}"),
        ]  # fmt: skip
        return table(("oil film", ""), rows, "", self.notes, 'f.static(load="500 N", speed="1000 rpm")')

    def __repr__(self) -> str:
        sizes = f"{self.viscosity:g} Pa*s, L {self.length:g} m, R {self.radius:g} m, c {self.clearance:g} m"
        return f"<rattle.Film: {self.model}, {self.cavitation}, {sizes}, L/D {self.ratio:.3g}>"

    @property
    def ratio(self) -> float:
        """Length over diameter L/D [-]."""
        return 0.5 * self.length / self.radius

    @property
    def notes(self) -> list[str]:
        """Remarks on the range of validity of the model."""
        remarks: list[str] = self._kind.leaf.notes(self._values)
        return remarks

    def force(
        self, ex: float, ey: float, vx: float, vy: float, omega_bush: float = 0.0, omega_pin: float = 0.0
    ) -> tuple[float, float, float, float, float]:
        """fx, fy [N] on the pin, torque_bush, torque_pin [N*m] about the own centre of each, and the loss [W].

        ex, ey [m]: centre of the pin minus centre of the bush; vx, vy [m/s]: its rate; in axes that do not turn.  A
        film thinner than 1e-6 of the clearance acts as one of this thickness, also where the pin would be beyond the
        bush.
        Raises InputError for numbers that are not finite.
        """
        state = [float(number) for number in (ex, ey, vx, vy, omega_bush, omega_pin)]
        if not all(map(math.isfinite, state)):
            raise InputError(f"a film has a force at finite places and speeds only, got {state}")
        kernel: Any = self._kind.kernel
        out = np.zeros(5)
        kernel(*state, self._p, 0, self._table, out)
        fx, fy, bush, pin, loss = out.tolist()
        return fx, fy, bush, pin, loss

    def static(self, load: Quantity, speed: Quantity) -> JournalPosition:
        """Where a pin that turns at `speed` [rad/s] in a bush at rest carries a steady load [N].

        Raises InputError for a load that needs a film thinner than 1e-6 of the clearance.
        """
        weight, turning = _positive("load", load), _speed(speed)
        return position_at(self, located(self, weight, turning, THINNEST), weight, turning)

    def critical_mass(self, load: Quantity, speed: Quantity) -> float:
        """Mass [kg] that the bearing carries, from which the pin begins to whirl; inf if no mass whirls at this speed.

        A rigid rotor on two such bearings has twice that mass.  Raises as `static` does.
        """
        position = self.static(load, speed)
        return threshold(position.stiffness, position.damping)[0]

    def peak_pressure(self, ex: float, ey: float, vx: float, vy: float, omega_mean: float = 0.0) -> float:
        """Largest pressure [Pa] in the film; omega_mean [rad/s]: mean of the rates of both bodies."""
        e, alpha, speed = self._polar(ex, ey, vx, vy, omega_mean)
        unit = self.viscosity * self.length**2 * speed / self.clearance**3
        return unit * self._of_law("peak", e, alpha) if speed > 0.0 else 0.0

    def leakage(self, ex: float, ey: float, vx: float, vy: float, omega_mean: float = 0.0) -> float:
        """Oil that flows out of both ends [m^3/s]; omega_mean [rad/s]: mean of the rates of both bodies."""
        e, alpha, speed = self._polar(ex, ey, vx, vy, omega_mean)
        return 2.0 * self.radius * self.length * speed * self._of_law("leakage", e, alpha)

    def _of_law(self, name: str, e: float, alpha: float) -> float:
        """A ratio that the law knows of one state."""
        return float(getattr(self._kind.leaf, name)(self._values, np.array([e]), np.array([alpha]))[0])

    def _polar(self, ex: float, ey: float, vx: float, vy: float, omega: float) -> tuple[float, float, float]:
        """Eccentricity [of the clearance], angle [0, pi] from it to the velocity that the film sees, and its size."""
        ux, uy = vx + omega * ey, vy - omega * ex
        e = min(math.hypot(ex, ey) / self.clearance, 1.0 - THINNEST)
        return e, abs(math.atan2(ex * uy - ey * ux, ex * ux + ey * uy)), math.hypot(ux, uy)

    def table(self, eccentricities: Sequence[float] = SHOWN) -> DataFrame:
        """The static positions as a pandas.DataFrame, without units and the same for every load and speed.

        One row for each eccentricity [of the clearance], with w the speed, N = w/(2 pi) and W the load: `attitude`
        [rad]; `sommerfeld` S = mu N (2 R L/W) (R/c)^2; `friction` (R/c) times its coefficient; `pressure` the largest
        over W/(2 R L); `leakage` over R c N L; stiffness `k_xx` ... times c/W and damping `c_xx` ... times c w/W (x
        along the load, y turned from it in the sense of the speed); `critical_mass` times c w^2/W; `whirl`, its
        frequency at the threshold over w, nan where there is none.  Raises InputError, MissingPackage.
        """
        pandas = package("pandas", "a table of a film")
        return pandas.DataFrame(locus(self, eccentricities))

    def stribeck(
        self, load: Quantity, speeds: Sequence[Quantity] | None = None, *, boundary_film: Quantity,
        friction: float = 0.1, stiffness: Quantity | None = None,
    ) -> DataFrame:  # fmt: skip
        """Stribeck's curve: friction under a steady load [N] over the speed, as a pandas.DataFrame.

        The pin turns in a bush at rest; speeds: [rad/s], by default five decades about the one from which the film
        carries alone.  boundary_film: thickness [m] at which the surfaces begin to touch, 3 times the roughness of both
        together; friction: dry coefficient; stiffness: of the dry contact [N/m], by default so stiff that the load
        presses it by a hundredth of the boundary film.
        Columns: `speed` [rad/s]; `eccentricity` [of the clearance]; `attitude` [rad]; `film_thickness` [m]; `dry`,
        the share of the load on the asperities; `friction`, coefficient at the radius of the bush; `torque` [N*m];
        `loss` [W].  Raises InputError for a boundary film of half the clearance or more, MissingPackage.
        """
        pandas = package("pandas", "a Stribeck curve")
        return pandas.DataFrame(self._stribeck(load, speeds, boundary_film, friction, stiffness))

    def _stribeck(
        self, load: Quantity, speeds: Sequence[Quantity] | None, boundary_film: Quantity, friction: float,
        stiffness: Quantity | None,
    ) -> dict[str, Array]:  # fmt: skip
        from rattle.questions.film import stribeck

        weight, boundary = _positive("load", load), _positive("boundary_film", boundary_film)
        if not boundary < 0.5 * self.clearance:
            words = f"the boundary film of {boundary:.3g} m must be thinner than half the clearance"
            raise InputError(f"{words} of {self.clearance:.3g} m")
        if not (math.isfinite(friction) and friction >= 0.0):
            raise InputError(f"friction is a coefficient, 0 or more, not {friction!r}")
        k = weight / (stribeck.SINKS * boundary) if stiffness is None else _positive("stiffness", stiffness)
        kernel: Any = self._kind.kernel
        parameters, out = self._packed(boundary), np.zeros(5)

        def force(e: float, w: float) -> tuple[float, ...]:
            kernel(e, 0.0, 0.0, 0.0, 0.0, w, parameters, 0, self._table, out)
            return tuple(out.tolist())

        if speeds is None:
            alone = stribeck.lift_off(force, weight, self.clearance - boundary)
            speeds = [float(w) for w in np.geomspace(1e-3 * alone, 1e2 * alone, 251)]
        turning = [abs(_speed(speed)) for speed in speeds]
        sizes = (self.radius, self.clearance)
        return stribeck.stribeck_curve(force, weight, turning, sizes, boundary, float(friction), k)

    def plot_stribeck(
        self, load: Quantity, speeds: Sequence[Quantity] | None = None, *, boundary_film: Quantity,
        friction: float = 0.1, stiffness: Quantity | None = None,
    ) -> Figure:  # fmt: skip
        """Stribeck's curve, and the thickness of the film, over the speed; arguments and errors as of `stribeck`."""
        from rattle.questions.film.pictures import plot_stribeck

        columns = self._stribeck(load, speeds, boundary_film, friction, stiffness)
        return plot_stribeck(self, columns, _positive("load", load), _positive("boundary_film", boundary_film))

    def plot(
        self, load: Quantity | None = None, speed: Quantity | None = None, *, result: Result | None = None,
        joint: str = "",
    ) -> Figure:  # fmt: skip
        """Eccentricity and attitude over the Sommerfeld number, and the path of the pin's centre in its clearance.

        With a load [N] and a speed [rad/s] their point is drawn; with a result of `orbit` or `simulate` and the name of
        a joint with oil, where that joint is at every output: what carries more than its static load is being squeezed.
        Raises as `static` does, and UnknownName for a joint without oil.
        """
        from rattle.questions.film.pictures import load_points, plot_film

        if (load is None) != (speed is None):
            raise InputError("the point of a load needs both, load and speed")
        position = None if load is None or speed is None else self.static(load, speed)
        return plot_film(self, position, None if result is None else load_points(result, joint))


def _kind(model: str) -> registry.Kind[FilmLaw]:
    kinds = registry.kinds("film")
    if model not in kinds:
        raise InputError(f"no film '{model}'{suggest(str(model), kinds)}; there are {', '.join(sorted(kinds))}")
    return kinds[model]


def _check_words(kind: registry.Kind[FilmLaw], chosen: dict[str, str]) -> None:
    """Raise InputError for a word that the law does not have."""
    for key, word in chosen.items():
        choices = kind.fields[key].choices if key in kind.fields else ("reynolds",)
        if word not in choices:
            expected = f"{key} of a film '{kind.name}' is {' or '.join(repr(choice) for choice in choices)}"
            raise InputError(f"{expected}, not {word!r}{suggest(str(word), choices)}")


def _positive(name: str, value: Quantity) -> float:
    unit, example = EXAMPLES[name]
    number = in_si(_no_flag(name, value), name, unit, example)
    if not (number > 0.0 and math.isfinite(number)):
        raise InputError(f"{name} must be positive and finite, as in {example}; got {value!r}")
    return number


def _speed(value: Quantity) -> float:
    unit, example = EXAMPLES["speed"]
    number = in_si(_no_flag("speed", value), "speed", unit, example)
    if number == 0.0 or not math.isfinite(number):
        raise InputError(f"speed must be finite and not zero, as in {example}: a film at rest carries nothing")
    return number


def _no_flag(name: str, value: Any) -> Any:
    """The value, unless it is True or False, which Python takes for numbers."""
    if isinstance(value, bool):
        unit, example = EXAMPLES[name]
        raise WrongType(f"{name} is a number in {unit}, as in {example}; got {value!r}")
    return value
