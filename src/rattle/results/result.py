"""What a run leaves behind: numbers, their names and units, and how far to trust them.

A `Result` holds no other object of the package, so that a file written today stays readable.
"""

from __future__ import annotations

import csv
import difflib
import math
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rattle.atomic_file import atomic

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.contact_summary import ContactSummary
    from rattle.results.display import Picture

Array = NDArray[np.float64]
TABLES = (".csv", ".txt", ".dat", "")  # suffixes under which text is expected
FEW = 6  # steps in the shortest contact below which its forces are coarse


class Event(NamedTuple):
    """One change of a contact, or a jump of a driver; what does not apply to its kind is zero.

    jolt: `joint` is the driver, `normal_speed` its speed after less that before [rad/s or m/s], `impulse` acts on its
    body B [N m s or N s], `energy_lost` is minus what the driver puts in.
    """

    t: float  # [s]
    joint: str
    kind: str  # contact | release | impact | stick | slip | jolt
    normal_speed: float = 0.0  # approach speed [m/s]
    duration: float = 0.0  # [s]
    peak_force: float = 0.0  # [N]
    impulse: float = 0.0  # [N s]
    energy_lost: float = 0.0  # [J]


class Peak(NamedTuple):
    """The largest size of one quantity over a whole run, from within its steps."""

    value: float  # in the unit of the quantity
    t: float  # [s]
    rms: float  # root mean square over the run


class UnknownName(KeyError):
    """A result has no curve of this name."""

    def __str__(self) -> str:
        return str(self.args[0])  # KeyError would put the sentence in quotes


# ---------------------------------------------------------------- trust
@dataclass(frozen=True, eq=False, repr=False)
class Trust:
    """How far a result can be trusted; `str()` says it in two lines."""

    drift: float  # largest distance between points that belong together [m]
    drift_joint: str = ""  # where
    energy_balance: float = math.nan  # largest unexplained change of energy [J]; NaN where there is no audit
    t_end: float = 0.0  # last instant of the run [s]
    horizon: float | None = None  # time up to which a tighter run agrees [s]; None: not asked
    pulled: Mapping[str, float] = field(default_factory=dict)  # massless-link joint -> share of time with N < 0
    first_pull: Mapping[str, float | None] = field(default_factory=dict)  # ... -> first such time [s]
    intervals: Mapping[str, Array] = field(default_factory=dict)  # ... -> (k, 2) times with N < 0 [s]
    contacts: int | None = None  # contacts that started; None: no joint can touch and let go
    impacts: int = 0  # impacts without duration
    fewest_steps: float | None = None  # steps in the shortest contact
    nonunique: tuple[str, ...] = ()  # joints whose reactions are not unique
    notes: tuple[str, ...] = ()
    drift_angle: float = 0.0  # largest angle between bodies that belong together [rad]
    stopped: bool = False  # the run ended before its time
    horizon_motion: float | None = None  # time up to which positions and rates agree [s]
    horizon_curve: str = ""  # the curve that parts first
    energy_share: float | None = None  # the same change as a share of the largest of kinetic energy, work and potential

    def __repr__(self) -> str:
        return f"<rattle.Trust: {self._accuracy()}; {self._reach()}>"

    def _repr_html_(self) -> str:
        from rattle.results.display import lines

        return lines(str(self))

    def __str__(self) -> str:
        remarks = "; ".join(one for one in (self._pulling(), *self._remarks()) if one)
        first = f"{self._accuracy()}; {self._reach()}"
        return f"{first}\n{remarks}" if remarks else f"{self._accuracy()}\n{self._reach()}"

    def _accuracy(self) -> str:
        where = f" (worst at {self.drift_joint})" if self.drift_joint and self.drift > 0 else ""
        energy = "" if math.isnan(self.energy_balance) else f", energy to {_short(abs(self.energy_balance))} J"
        off = self.energy_share or 0.0
        share = f" ({_short(off)} of the largest energy)" if off > 1e-6 else ""
        angle = f" and {_short(self.drift_angle)} rad" if self.drift_angle > self.drift else ""
        return f"constraints held to {_short(self.drift)} m{angle}{where}{energy}{share}"

    def _reach(self) -> str:
        if self.horizon is None:
            return "how long the curves can be trusted was not asked (horizon=True does)"
        whole = f"up to where the run ended, t = {self.t_end:.4g} s"
        if not self.stopped:
            whole = f"over the whole run, to t = {self.t_end:.4g} s"
        agree = self.horizon >= self.t_end or (self.stopped and not self.horizon_curve)
        if agree and self.horizon > 0.0:
            return f"the curves can be trusted {whole}"
        motion = self.horizon_motion
        if motion is not None and motion > 2.0 * self.horizon:
            until = whole if motion >= self.t_end else f"up to t = {motion:.3g} s (horizon)"
            first = f" ({self.horizon_curve} parts first)" if self.horizon_curve else ""
            return f"positions and rates can be trusted {until}, all other curves up to t = {self.horizon:.3g} s{first}"
        return f"the curves can be trusted up to t = {self.horizon:.3g} s (horizon), after it statistics only"

    def coarse(self) -> tuple[str, ...]:
        """What to say where the shortest contact took too few steps."""
        if self.fewest_steps is None or self.fewest_steps >= FEW:
            return ()
        return (f"the shortest contact took {_steps(self.fewest_steps)}: too few for its peak, tighten rtol",)

    def _touching(self) -> str:
        """Contacts and impacts, in words; empty where no joint can touch and let go."""
        if self.contacts is None:
            return ""
        counts = [
            f"{n} {what}{'s' if n != 1 else ''}"
            for n, what in ((self.contacts, "contact"), (self.impacts, "impact"))
            if n
        ]
        if not counts:
            return "no contact in the whole run"
        if self.fewest_steps is None:
            return " and ".join(counts)
        coarse = ": too few for its peak, tighten rtol" if self.fewest_steps < FEW else ""
        return f"{' and '.join(counts)}, the shortest contact took {_steps(self.fewest_steps)}{coarse}"

    def _pulling(self) -> str:
        return "; ".join(one for one in (self._links(), self._touching()) if one)

    def _links(self) -> str:
        pulling = sorted((j for j, share in self.pulled.items() if share > 0), key=lambda j: -self.pulled[j])
        if not self.pulled:
            return ""
        if not pulling:
            return f"{' and '.join(self.pulled)} would never have to pull: the pin stays on its bush all the time"
        said = [f"{j} {'would have to pull ' if n == 0 else ''}{self._how_much(j)}" for n, j in enumerate(pulling[:3])]
        more = [f"{len(pulling) - 3} more pins"] if len(pulling) > 3 else []
        pin = "the pin" if len(pulling) == 1 else "these pins"
        return f"{', and '.join(said + more)}: {pin} would lift off; this model does not hold there"

    def _how_much(self, joint: str) -> str:
        share, first = 100 * self.pulled[joint], self.first_pull.get(joint)
        part = f"for {share:.0f} % of the run" if share >= 1 else "for less than 1 % of the run"
        return part if first is None else f"{part}, first at t = {first:.4g}{' s' if first else ''}"

    def _remarks(self) -> list[str]:
        joints = ", ".join(self.nonunique)
        return ([f"reactions not unique (redundant constraints) at {joints}"] if joints else []) + list(self.notes)

    def to_dict(self) -> dict[str, Any]:
        """The same as numbers, texts and lists, ready for JSON."""
        return asdict(self) | {"intervals": {j: np.asarray(v).tolist() for j, v in self.intervals.items()}}

    @classmethod
    def from_dict(cls, record: Mapping[str, Any]) -> Trust:
        """The inverse of `to_dict`."""
        intervals = {j: np.asarray(v, float).reshape(-1, 2) for j, v in record["intervals"].items()}
        texts = {key: tuple(record[key]) for key in ("nonunique", "notes")}
        return cls(**{**record, **texts, "intervals": intervals})


def _steps(count: float) -> str:
    return f"{count:.0f} step{'s' if round(count) != 1 else ''}"


def _short(value: float) -> str:
    return f"{value:.1g}".replace("e-0", "e-")


# ---------------------------------------------------------------- the result
class Result:
    """Motion, reactions and energy of one run, by name.

    t: (n,) instants [s].  data: (n, len(names)) one column per stored name, SI units.
    geometry: plain description of bodies, joints and loads, enough to draw the mechanism.
    success, message: whether the run came to its end, and if not why and what to try.
    """

    def __init__(
        self,
        *,
        t: ArrayLike,
        data: ArrayLike,
        names: Iterable[str],
        units: Mapping[str, str],
        geometry: Mapping[str, Any],
        trust: Trust,
        stats: Mapping[str, Any],
        provenance: Mapping[str, Any],
        events: Iterable[Event] = (),
        success: bool = True,
        message: str = "",
        peaks: Mapping[str, Peak] | None = None,
    ) -> None:
        self.t: Array = _frozen(t)
        self.stored: tuple[str, ...] = tuple(names)
        self.geometry = dict(geometry)
        self.trust = trust
        self.stats = dict(stats)
        self.provenance = dict(provenance)
        self.events: tuple[Event, ...] = tuple(events)
        self.success = success
        self.message = message
        self.peaks: dict[str, Peak] = dict(peaks or {})
        self._data = _frozen(data)
        if self._data.shape != (len(self.t), len(self.stored)):
            raise ValueError(f"data is {self._data.shape}; wanted {(len(self.t), len(self.stored))}")
        self._column = {name: k for k, name in enumerate(self.stored)}
        self._derived = _derived(self.geometry, self._column)
        self._units = {name: units[name] for name in self.stored}
        self._units |= {name: "N" if rule[0] == "force" else "m" for name, rule in self._derived.items()}

    def __repr__(self) -> str:
        span = f"{len(self.t)} instants, {self.t[0]:g} to {self.t[-1]:g} s" if len(self.t) else "no instant"
        return f"<rattle.Result: {span}, {len(self.names)} names{'' if self.success else ', FAILED'}>"

    def _repr_html_(self) -> str:
        from rattle.results.contact_summary import joint_rows
        from rattle.results.display import table

        said = [] if self.success else [f"stopped: {self.message}"]
        title = f"{self.provenance.get('model') or 'mechanism'}: {repr(self)[1:-1]}"
        return table(*joint_rows(self), title, [*said, *str(self.trust).splitlines()])

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    @property
    def names(self) -> tuple[str, ...]:
        """All names `r[...]` answers to: the stored ones, then those derived from them."""
        return self.stored + tuple(self._derived)

    def __contains__(self, name: object) -> bool:
        return name in self._column or name in self._derived

    @property
    def interrupted(self) -> bool:
        """True where the user stopped the run (Ctrl-C); the result ends there."""
        return bool(self.stats.get("interrupted", False))

    def __setstate__(self, state: dict[str, Any]) -> None:
        """From a copy by pickle, whose arrays could be written."""
        self.__dict__.update(state)
        self.t, self._data = _frozen(self.t), _frozen(self._data)

    def __getitem__(self, name: str) -> Array:
        """One curve, (n,), read-only.  Raises UnknownName (a KeyError) with suggestions."""
        if not isinstance(name, str):
            raise TypeError(f"a curve is asked for by one name in quotes, got {name!r}")
        if name in self._column:
            return self._data[:, self._column[name]]
        if name not in self._derived:
            raise UnknownName(self._unknown(name))
        what, owner, x, y = self._derived[name]
        if what == "force":
            return np.hypot(self[f"{owner}.fx"], self[f"{owner}.fy"])
        cos, sin = np.cos(self[f"{owner}.angle"]), np.sin(self[f"{owner}.angle"])
        turned = cos * x - sin * y if what == "x" else sin * x + cos * y
        return np.asarray(self[f"{owner}.{what}"] + turned)

    def unit(self, name: str) -> str:
        """SI unit of a curve ("" for a bare number).  Raises UnknownName."""
        if name not in self._units:
            raise UnknownName(self._unknown(name))
        return self._units[name]

    def peak(self, name: str) -> tuple[float, float]:
        """Largest size of a curve and when [s].

        For the force, moment, normal and tangential force of joints and effort and power of drivers of a run in time
        it comes from within the steps of the whole run, whatever the outputs are; `.peaks` holds all of them.  For
        other curves it is the top of a smooth curve through the outputs.  Raises UnknownName, ValueError without
        any output.
        """
        from rattle.results import contact_summary

        return contact_summary.peak(self, name)

    def rms(self, name: str) -> float:
        """Root mean square of a curve over time: where `peak` knows the steps theirs, else that of the outputs."""
        from rattle.results import contact_summary

        return contact_summary.rms_of(self, name)

    def _unknown(self, name: str) -> str:
        owner, _, _ = name.partition(".")
        near = difflib.get_close_matches(name, self.names, n=3, cutoff=0.6)
        near = near or [other for other in self.names if other.split(".")[0] == owner][:6]
        hint = (
            f"did you mean {' or '.join(repr(n) for n in near)}?"
            if near
            else "r.names (on the command line `rattle plot RESULT`) lists all"
        )
        return f"the result has no {name!r}; {hint}"

    @property
    def contacts(self) -> dict[str, ContactSummary]:
        """Per joint with play: share of time in contact, contacts, impacts, peak and RMS force, energy lost."""
        from rattle.results import contact_summary

        return contact_summary.contacts(self)

    # ------------------------------------------------------------ to other programs
    def to_dataframe(self) -> Any:
        """pandas.DataFrame of all names, index t [s], units in `.attrs["units"]`."""
        from rattle.results.archive import package

        pandas = package("pandas", "to_dataframe")
        index = pandas.Index(self.t, name="t")
        frame = pandas.DataFrame({name: self[name] for name in self.names}, index=index)
        frame.attrs["units"] = dict(self._units)
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """xarray.Dataset of all names over the coordinate t; attributes: units, what was run, how far to trust it."""
        dataset = self._dataset(self.names)
        ran = {key: str(value) for key, value in self.provenance.items() if value is not None}
        dataset.attrs = {**ran, "success": str(self.success), "message": self.message, "trust": str(self.trust)}
        return dataset

    def _dataset(self, names: Iterable[str]) -> xarray.Dataset:
        from rattle.results.archive import package

        curves = {name: ("t", self[name], {"units": self._units[name]}) for name in names}
        dataset: xarray.Dataset = package("xarray", "to_xarray").Dataset(curves, {"t": ("t", self.t, {"units": "s"})})
        return dataset

    def to_csv(self, path: str | os.PathLike[str], *, fallback: str | os.PathLike[str] | None = None) -> Path:
        """All names as CSV, with a header such as `coupler.x [m]`; numbers in full precision.

        fallback, return value: as for `save`.  Raises ValueError for a suffix that promises something else, OSError.
        """
        require_table(path)
        units = [self._units[name] for name in self.names]
        header = ["t [s]"] + [
            f"{name} [{unit}]" if unit else name for name, unit in zip(self.names, units, strict=True)
        ]
        table = np.column_stack([self.t, *(self[name] for name in self.names)])

        def write(place: Path) -> None:
            with atomic(place) as file, file.open("w", newline="", encoding="utf-8") as out:
                writer = csv.writer(out, lineterminator="\n")
                writer.writerow(header)
                writer.writerows(table.tolist())

        return _first_place(write, path, fallback)

    def save(self, path: str | os.PathLike[str], *, fallback: str | os.PathLike[str] | None = None) -> Path:
        """Write everything as netCDF (`.nc`) or `.npz`; `load_result` gives it back, bit by bit.

        fallback: a folder for a file of the same name, if the system cannot write `path` (a full disk).
        Returns the file written.  Raises ValueError for another suffix, MissingPackage (an ImportError; `.npz` needs
        nothing more), OSError; the result itself stays as it is and can be saved elsewhere.
        """
        from rattle.results import archive

        record = {
            "names": self.stored,
            "units": {name: self._units[name] for name in self.stored},
            "geometry": self.geometry,
            "events": self.events,
            "trust": self.trust.to_dict(),
            "stats": self.stats,
            "provenance": self.provenance,
            "success": self.success,
            "message": self.message,
            "peaks": self.peaks,
        }
        return _first_place(lambda place: archive.write(place, record, self.t, self._data), path, fallback)

    # ------------------------------------------------------------ pictures
    @overload
    def plot(
        self, *names: str, ax: None = None, compare: Iterable[tuple[str, Result]] = (), robust: bool = False,
        over: str | None = None,
    ) -> Figure: ...  # fmt: skip
    @overload
    def plot(
        self, *names: str, ax: Axes, compare: Iterable[tuple[str, Result]] = (), robust: bool = False,
        over: str | None = None,
    ) -> Axes: ...  # fmt: skip
    def plot(
        self, *names: str, ax: Axes | None = None, compare: Iterable[tuple[str, Result]] = (), robust: bool = False,
        over: str | None = None,
    ) -> Figure | Axes:  # fmt: skip
        """Curves over time, one panel per unit, angles in degrees, short lengths in mm or µm.

        ax: draw there, in SI; then all names must have one unit.  Returns a new figure, or `ax` where it is given.
        compare: further results as (label, result), dashed.  robust: rare spikes are left out of the axis, and a note
        says how far they reach.  over: another curve, such as "crank.angle", in the place of time.
        Raises UnknownName, or ValueError where there is nothing to draw or one axis for two units.
        """
        from rattle.plots import curves as curves_

        return curves_.plot(self, *names, ax=ax, compare=compare, robust=robust, over=over)

    @overload
    def plot_orbit(self, joint: str, ax: None = None) -> Figure: ...
    @overload
    def plot_orbit(self, joint: str, ax: Axes) -> Axes: ...
    def plot_orbit(self, joint: str, ax: Axes | None = None) -> Figure | Axes:
        """Path of a pin in its clearance circle, coloured by the normal force; see `rattle.plots.curves.plot_orbit`.

        ax: draw there.  Returns a new figure, or `ax` where it is given.  Raises ValueError without clearance.
        """
        from rattle.plots import curves as curves_

        return curves_.plot_orbit(self, joint, ax=ax)

    def animate(
        self, path: str | os.PathLike[str], *, frames: int = 120, fps: int = 20, trace: Iterable[str] = (),
        dpi: float = 90.0, speed: float | None = None, names: bool = False,
    ) -> Picture:  # fmt: skip
        """The mechanism moving, as .gif or .mp4; a notebook shows it.

        At most `frames` pictures, evenly spaced in time, shown at `fps` per second.  trace: points ("coupler.P") that
        leave their path behind.  dpi: dots per inch.  speed: of the film against the motion, 0.1 for ten times
        slower; then there are as many frames as that takes.  names: write the names of bodies on them.
        Raises ValueError for another suffix or a result without instants, UnknownName, MissingProgram without ffmpeg.
        """
        from rattle.plots import animation
        from rattle.results.display import Picture

        animation.animate(self, path, frames=frames, fps=fps, trace=trace, dpi=dpi, speed=speed, names=names)
        return Picture(Path(path))


def load_result(path: str | os.PathLike[str]) -> Result:
    """Read what `Result.save` wrote.

    Raises FileNotFoundError, OSError where the file cannot be opened, MissingPackage (netCDF without h5py), and
    ValueError where the file is damaged or not a result of rattle.
    """
    from rattle.results import archive

    record, t, data = archive.read(path)
    try:
        return Result(
            t=t,
            data=data,
            names=record["names"],
            units=record["units"],
            geometry=record["geometry"],
            events=[Event(*event) for event in record["events"]],
            trust=Trust.from_dict(record["trust"]),
            stats=record["stats"],
            provenance=record["provenance"],
            success=record["success"],
            message=record["message"],
            peaks={name: Peak(*values) for name, values in record.get("peaks", {}).items()},
        )
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise ValueError(f"{path} {archive.NO_RESULT}") from error


# ---------------------------------------------------------------- pieces
def _derived(geometry: Mapping[str, Any], stored: Mapping[str, int]) -> dict[str, tuple[str, str, float, float]]:
    """Names that follow from stored columns: what ("x", "y" or "force"), of whom, and the point in its frame [m]."""
    found: dict[str, tuple[str, str, float, float]] = {}
    for body, form in geometry.get("bodies", {}).items():
        for point, (x, y) in form["points"].items():
            found |= {f"{body}.{point}.{axis}": (axis, body, x, y) for axis in "xy" if f"{body}.{axis}" in stored}
    for joint in geometry.get("joints", {}):
        if f"{joint}.fx" in stored and f"{joint}.force" not in stored:
            found[f"{joint}.force"] = ("force", joint, 0.0, 0.0)
    return found


def require_table(path: str | os.PathLike[str]) -> None:
    """Raise ValueError for a name under which nobody expects CSV."""
    if Path(path).suffix.lower() not in TABLES:
        raise ValueError(f"{os.fspath(path)}: curves are written as plain text; give a name ending in .csv")


def _first_place(
    write: Callable[[Path], None], path: str | os.PathLike[str], fallback: str | os.PathLike[str] | None
) -> Path:
    """Write under `path`, or in the folder `fallback` where the system cannot; returns the file written."""
    try:
        write(Path(path))
        return Path(path)
    except OSError:
        if fallback is None:
            raise
    place = Path(fallback).expanduser() / Path(path).name
    write(place)
    return place


def _frozen(values: ArrayLike) -> Array:
    view = np.asarray(values, dtype=np.float64).view()
    view.flags.writeable = False
    return view
