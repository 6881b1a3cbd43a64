"""The result of an analysis: numbers, their names and units, and how far to trust them.

A `Result` refers to no model or system, so that a file written today stays readable.
"""

from __future__ import annotations

import csv
import difflib
import functools
import os
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rattle.asked import OfResult
from rattle.atomic_file import atomic
from rattle.errors import ALIKE, InputError, WrongType
from rattle.results import archive, contact_summary, film_summary
from rattle.results.chosen_units import SI, column_unit
from rattle.results.derived import rules, unit_of_rule, value_of
from rattle.results.display import Picture, card, grid, marks, printed
from rattle.results.event import Breaks, Event, Peak
from rattle.results.table_file import require_table
from rattle.results.trust import Trust
from rattle.value_types import Tree
from rattle.wrong_arguments import answer_in_words, answers_in_words

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.exchange.residuals import Residual


Array = NDArray[np.float64]
NEXT_TO = 1e-6  # share of the mean interval of outputs within which an output lies on an event


class UnknownName(InputError, KeyError):
    """A result has no curve of this name."""

    def __str__(self) -> str:
        return str(self.args[0])  # KeyError would print the message in quotes


# ---------------------------------------------------------------- the result
@answers_in_words
class Result(OfResult):
    """Motion, reactions and energy of one run, by name.

    t: (n,) instants [s].  data: (n, len(names)) one column per stored name, SI units.
    geometry: plain description of bodies, joints and loads, from which the mechanism is drawn.
    success, message: whether the run reached its end, and if not, why and what to try.
    """

    def __init__(
        self,
        *,
        t: ArrayLike,
        data: ArrayLike,
        names: Iterable[str],
        units: Mapping[str, str],
        geometry: Tree,
        trust: Trust,
        stats: Tree,
        provenance: Tree,
        events: Iterable[Event] = (),
        success: bool = True,
        message: str = "",
        peaks: Mapping[str, Peak] | None = None,
        breaks: Breaks | None = None,
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
        self.breaks = breaks  # values on both sides of impacts and other events
        self._data = _frozen(data)
        if self._data.shape != (len(self.t), len(self.stored)):
            raise InputError(f"data has shape {self._data.shape}; expected {(len(self.t), len(self.stored))}")
        self._column = {name: k for k, name in enumerate(self.stored)}
        self._derived = rules(self.geometry, self._column)
        self._units = {name: units[name] for name in self.stored}
        self._units |= {name: unit_of_rule(name, rule) for name, rule in self._derived.items()}

    def __repr__(self) -> str:
        span = f"{len(self.t)} instants, {self.t[0]:g} to {self.t[-1]:g} s" if len(self.t) else "no instant"
        return f"<rattle.Result: {span}, {len(self.names)} names{'' if self.success else ', FAILED'}>"

    def _repr_html_(self) -> str:
        title = f"{self.provenance.get('model') or 'mechanism'}: {repr(self)[1:-1].partition(': ')[2]}"
        summaries = (contact_summary.joint_rows(self), film_summary.film_rows(self))
        tables = [grid(head, rows) for head, rows in summaries if rows]
        sentences = [] if self.success else [marks([("bad", f"stopped: {self.message}")])]
        sentences += [f"<p>{escape(line)}</p>" for line in contact_summary.contact_lines(self)]
        sentences += [f"<p>{escape(printed(line))}</p>" for line in (self.trust.word, *self.trust.why)]
        forces = (f"{joint}.force" for joint in self.geometry["joints"] if f"{joint}.fx" in self)
        return card(title, *tables, *sentences, hint=f'r.plot("{next(forces, self.names[0])}"), r.trust')

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    @property
    def names(self) -> tuple[str, ...]:
        """All names that `r[...]` knows: the stored ones, then those derived from them."""
        return self.stored + tuple(self._derived)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and (name in self._column or name in self._derived)

    @property
    def interrupted(self) -> bool:
        """True if the user stopped the run (Ctrl-C); the result ends there."""
        return bool(self.stats.get("interrupted", False))

    @property
    def cut_short(self) -> bool:
        """True if the user stopped the run, or the second one that tells how long it can be trusted."""
        return self.interrupted or bool(self.stats.get("horizon_interrupted", False))

    def whole(self) -> Self:
        """This result.  Raises KeyboardInterrupt if it was cut short, so that what it is a part of ends too."""
        if self.cut_short:
            raise KeyboardInterrupt
        return self

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a pickled copy and make its arrays read-only again."""
        self.__dict__.update(state)
        self.t, self._data = _frozen(self.t), _frozen(self._data)

    def __getitem__(self, name: str) -> Array:
        """One curve, (n,), in its SI unit, read-only.  Raises UnknownName (a KeyError) with suggestions."""
        if not isinstance(name, str):
            raise WrongType(f"expected one name of a curve in quotes, got {name!r}")
        if name in self._column:
            return self._data[:, self._column[name]]
        if name not in self._derived:
            raise UnknownName(self._unknown(name))
        return np.asarray(value_of(self._derived[name], self.__getitem__, np.cos, np.sin, np.hypot))

    @functools.cached_property
    def left_out(self) -> np.ndarray:
        """(n,) True at instants next to singular positions, at which reactions are nan, for they are not determined."""
        if not self.trust.singular:
            return np.zeros(len(self.t), bool)
        return ~np.asarray(np.isfinite(self._data).all(axis=1))

    @functools.cached_property
    def with_breaks(self) -> Result:
        """The same with the instants of events, each twice: its values are those just before and just after.

        Between two of them all curves are smooth.  Outputs that lie on an event, or next to it, are left out.
        """
        if self.breaks is None or len(self.t) < 2:
            return self
        inside = (self.breaks.t > self.t[0]) & (self.breaks.t <= self.t[-1])
        t, data = self.breaks.t[inside], self.breaks.data[inside]
        if not len(t):
            return self
        gap = NEXT_TO * float(self.t[-1] - self.t[0]) / (len(self.t) - 1)
        after = np.searchsorted(t, self.t)
        before = np.abs(t[np.maximum(after - 1, 0)] - self.t)
        apart = np.minimum(before, np.abs(t[np.minimum(after, len(t) - 1)] - self.t)) > gap
        apart[0] = True
        apart[-1] = t[-1] < self.t[-1]
        times = np.concatenate([self.t[apart], t])
        order = np.argsort(times, kind="stable")
        return Result(
            t=times[order], data=np.concatenate([self._data[apart], data])[order], names=self.stored,
            units=self._units, geometry=self.geometry, trust=self.trust, stats=self.stats,
            provenance=self.provenance, events=self.events, success=self.success, message=self.message,
            peaks=self.peaks,
        )  # fmt: skip

    def unit(self, name: str) -> str:
        """SI unit of a curve ("" if it has none).  Raises UnknownName."""
        if name not in self._units:
            raise UnknownName(self._unknown(name))
        return self._units[name]

    def peak(self, name: str) -> tuple[float, float]:
        """Largest magnitude of a curve, in its SI unit, and its time [s].

        For the force, moment, normal and tangential force of joints, the tight strand of a belt, and for effort and
        power of drivers in a run in time it is found within the steps of the whole run, whatever the output interval;
        `.peaks` holds all of them.  For other curves it is the maximum of a smooth curve through the outputs.  Raises
        UnknownName, ValueError without any output.
        """
        return contact_summary.peak(self, name)

    def rms(self, name: str) -> float:
        """Root mean square of a curve over time, in its SI unit: from within the steps where `peak` is, otherwise from
        the outputs.  Raises UnknownName."""
        return contact_summary.rms_of(self, name)

    def _unknown(self, name: str) -> str:
        owner, _, _ = name.partition(".")
        near = difflib.get_close_matches(name, self.names, n=3, cutoff=ALIKE)
        near = near or [other for other in self.names if other.split(".")[0] == owner][:6]
        hint = (
            f"did you mean {' or '.join(repr(n) for n in near)}?"
            if near
            else "r.names (on the command line `rattle plot RESULT`) lists all"
        )
        return f"the result has no {name!r}; {hint}"

    @property
    def contacts(self) -> dict[str, contact_summary.ContactSummary]:
        """For each joint with clearance: share of time in contact, contacts, impacts, peak and RMS force [N], energy
        lost [J]; all fields in `ContactSummary`."""
        return contact_summary.contacts(self)

    @property
    def films(self) -> dict[str, film_summary.FilmSummary]:
        """For each joint with oil: least film [m], pressure [Pa], power [W], leakage; fields in `FilmSummary`."""
        return film_summary.films(self)

    # ------------------------------------------------------------ to other programs
    def to_dataframe(self, *, units: str | Iterable[str] | None = None) -> Any:
        """pandas.DataFrame of all names, index t, with its units in `.attrs["units"]`.

        units: such as "mm,deg"; what they leave open is in SI, as everything is without them.
        Raises MissingPackage, InputError for unknown units.
        """
        from rattle.results.archive import package

        pandas = package("pandas", "to_dataframe")
        shown = {name: column_unit(self._units[name], units or SI) for name in self.names}
        time = column_unit("s", units or SI)
        index = pandas.Index(time.factor * self.t, name="t")
        frame = pandas.DataFrame({name: quantity.factor * self[name] for name, quantity in shown.items()}, index=index)
        frame.attrs["units"] = (
            {"t": time.unit} | {name: quantity.unit for name, quantity in shown.items()} if units else dict(self._units)
        )
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """xarray.Dataset of all names over the coordinate t [s]; attributes: SI units, what was run, how far to trust
        it.  Raises MissingPackage."""
        dataset = self._dataset(self.names)
        ran = {key: str(value) for key, value in self.provenance.items() if value is not None}
        dataset.attrs = {**ran, "success": str(self.success), "message": self.message, "trust": str(self.trust)}
        return dataset

    def _dataset(self, names: Iterable[str]) -> xarray.Dataset:
        from rattle.results.archive import package

        curves = {name: ("t", self[name], {"units": self._units[name]}) for name in names}
        dataset: xarray.Dataset = package("xarray", "to_xarray").Dataset(curves, {"t": ("t", self.t, {"units": "s"})})
        return dataset

    def to_csv(
        self, path: str | os.PathLike[str], *, fallback: str | os.PathLike[str] | None = None,
        units: str | Iterable[str] | None = None, names: Sequence[str] | None = None,
    ) -> Path:  # fmt: skip
        """Write curves as CSV, with a header such as `coupler.x [m]`; numbers in full precision.

        units: such as "mm,deg"; what they leave open is in SI, as everything is without them.
        names: the curves; None: all, in their order.  fallback, return value: as for `save`.
        Raises InputError for a suffix of another format, UnknownName, OSError.
        """
        require_table(path)
        header, table = self.titled_columns(names, units)

        def write(place: Path) -> None:
            with atomic(place) as file, file.open("w", newline="", encoding="utf-8") as out:
                writer = csv.writer(out, lineterminator="\n")
                writer.writerow(header)
                writer.writerows(table.tolist())

        return archive.first_place(write, path, fallback)

    def to_excel(
        self, path: str | os.PathLike[str], *, fallback: str | os.PathLike[str] | None = None,
        units: str | Iterable[str] | None = None, names: Sequence[str] | None = None,
    ) -> Path:  # fmt: skip
        """Write a workbook (`.xlsx`): sheets `curves`, one for each joint, `peaks`, `events`, `parameters`, `trust`.

        The first row of curves is as that of a CSV file, numbers have full precision; nan is an empty cell, infinity
        the text "inf".  Arguments, return value as of `to_csv`.
        Raises InputError for another suffix or too many numbers, UnknownName, OSError.
        """
        from rattle.exchange import result_workbook

        return result_workbook.write_workbook(self, path, fallback=fallback, units=units, names=names)

    def to_mat(
        self, path: str | os.PathLike[str], *, fallback: str | os.PathLike[str] | None = None,
        units: str | Iterable[str] | None = None, names: Sequence[str] | None = None,
    ) -> Path:  # fmt: skip
        """Write a MATLAB file (`.mat`, version 5) with a struct `r`: `t` (n, 1) [s], cells `names` and `units` (m),
        `values` (n, m), `parameters`, `events`, `trust`.

        Arguments, return value as of `to_csv`.  Raises InputError for another suffix or too many numbers, UnknownName,
        OSError.
        """
        from rattle.exchange import matlab

        return matlab.write_mat(self, path, fallback=fallback, units=units, names=names)

    def titled_columns(
        self, names: Sequence[str] | None = None, units: str | Iterable[str] | None = None
    ) -> tuple[list[str], Array]:
        """Titles such as `coupler.x [m]`, the first of time, and their columns (n, 1 + len(names)), in these units.

        names, units: as of `to_csv`.  Raises UnknownName, InputError.
        """
        words = [*units] if units is not None and not isinstance(units, str) else units
        columns = self.names if names is None else tuple(names)
        time, shown = column_unit("s", words), [column_unit(self.unit(name), words) for name in columns]
        titles = [f"t [{time.unit}]"] + [
            f"{name} [{quantity.unit}]" if quantity.unit else name
            for name, quantity in zip(columns, shown, strict=True)
        ]
        curves = (quantity.factor * self[name] for name, quantity in zip(columns, shown, strict=True))
        return titles, np.column_stack([time.factor * self.t, *curves])

    def save(self, path: str | os.PathLike[str], *, fallback: str | os.PathLike[str] | None = None) -> Path:
        """Write everything as netCDF (`.nc`) or `.npz`; `load_result` reads it back, bit for bit.

        fallback: a folder for a file of the same name, if the system cannot write `path` (a full disk).
        Returns the file written.  Raises InputError for another suffix, MissingPackage (an ImportError; `.npz` needs
        no further package), OSError; the result is unchanged then and can be saved elsewhere.
        """
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
            **({"breaks": self.breaks.text} if self.breaks is not None else {}),
        }
        return archive.first_place(lambda place: archive.write(place, record, self.t, self._data), path, fallback)

    # ------------------------------------------------------------ pictures
    @overload
    def plot(
        self, *names: str, ax: None = None, compare: Iterable[tuple[str, Result]] = (), robust: bool = False,
        over: str | None = None, measured: str | Path | Iterable[str | Path | Residual] = (),
    ) -> Figure: ...  # fmt: skip
    @overload
    def plot(
        self, *names: str, ax: Axes, compare: Iterable[tuple[str, Result]] = (), robust: bool = False,
        over: str | None = None, measured: str | Path | Iterable[str | Path | Residual] = (),
    ) -> Axes: ...  # fmt: skip
    def plot(
        self, *names: str, ax: Axes | None = None, compare: Iterable[tuple[str, Result]] = (), robust: bool = False,
        over: str | None = None, measured: str | Path | Iterable[str | Path | Residual] = (),
    ) -> Figure | Axes:  # fmt: skip
        """Curves over time, one panel per unit, angles in degrees, short lengths in mm or µm.

        ax: draw there, in SI; then all names must have one unit.  Returns a new figure, or `ax` if it is given.
        compare: further results as (label, result), dashed.  robust: rare spikes are left out of the axis, and a note
        says how far they reach.  over: a curve for the horizontal axis instead of time, such as "crank.angle".
        measured: measured curves as dots, such as "measured.csv:theta=rocker.angle", and what they differ by below
        them; see `residuals`.  Raises UnknownName, or ValueError if there is nothing to draw or one axis for two units.
        """
        from rattle.plots import curves as curves_

        return curves_.plot(self, *names, ax=ax, compare=compare, robust=robust, over=over, measured=measured)

    def residuals(
        self, measured: str | Path | Iterable[str | Path | Residual], curves: Sequence[str] = ()
    ) -> tuple[Residual, ...]:
        """Measured curves beside those of this result: measured minus computed, at the measured times within the run.

        measured: files of numbers over time, each as "FILE", "FILE:COLUMN", "FILE:COLUMN=CURVE", with "@0.2s" behind
        it for what is added to its times.  Without a curve a column belongs to the curve of its name, or to the only
        one of its unit among `curves`.  Each has `.curve`, `.t`, `.values`, `.residual`, `.rms`, `.largest` in SI.
        Raises InputError with file and line for what cannot be read or does not fit, UnknownName.
        """
        from rattle.exchange.residuals import residuals as residuals_

        return residuals_(self, measured, curves)

    def plot_spectrum(self, *names: str, compare: Iterable[tuple[str, Result]] = ()) -> Figure:
        """Amplitude spectra of curves over the frequency [Hz], and multiples of the driver's turning if it is steady.

        From all output instants, with the window of Hann: see `spectrum`.  compare: further results as (label, result).
        Raises UnknownName, ValueError.
        """
        from rattle.plots import spectrum

        return spectrum.plot_spectrum(self, *names, compare=compare)

    def spectrum(self, name: str) -> tuple[Array, Array]:
        """Frequencies [Hz] and amplitudes [SI] of a curve from its output instants, which must be evenly spaced.

        The mean is taken out, the window is that of Hann: a sine of amplitude A shows as A.
        Raises UnknownName, ValueError.  For all details see `rattle.results.spectrum`.
        """
        from rattle.results.spectrum import amplitude_spectrum

        return amplitude_spectrum(self.t, self[name])

    def view(self, *, title: str = "", curves: Iterable[str] = (), language: str = "en") -> Any:
        """The motion in a notebook: play, curves, forces, orbits.  Returns a widget.

        title, curves, language: as of `animate`.  Raises MissingPackage without anywidget, ValueError for a result
        without motion, an unknown curve or language.
        """
        from rattle.pages.notebook import view_result
        from rattle.pages.wishes import Wishes

        return view_result(self, Wishes(title, tuple(curves), language=language))

    @overload
    def plot_path(self, *points: str, ax: None = None) -> Figure: ...
    @overload
    def plot_path(self, *points: str, ax: Axes) -> Axes: ...
    def plot_path(self, *points: str, ax: Axes | None = None) -> Figure | Axes:
        """Paths of points such as "coupler.P", or of mass centres ("coupler"), in the plane [m or mm].

        ax: draw there.  Returns a new figure, or `ax` if it is given.  Raises UnknownName, ValueError without a point.
        """
        from rattle.plots import orbit

        return orbit.plot_path(self, *points, ax=ax)

    @overload
    def plot_orbit(self, joint: str, ax: None = None) -> Figure: ...
    @overload
    def plot_orbit(self, joint: str, ax: Axes) -> Axes: ...
    def plot_orbit(self, joint: str, ax: Axes | None = None) -> Figure | Axes:
        """Path of a pin in its clearance circle [mm or µm], coloured by the normal force [N].

        For all details see `rattle.plots.orbit.plot_orbit`.
        ax: draw there.  Returns a new figure, or `ax` if it is given.  Raises InputError without clearance.
        """
        from rattle.plots import orbit

        return orbit.plot_orbit(self, joint, ax=ax)

    def animate(
        self, path: str | os.PathLike[str], *, frames: int = 120, fps: int = 20, trace: Iterable[str] = (),
        dpi: float = 90.0, speed: float | None = None, names: bool = False, power: bool = False,
        stress: bool = False, title: str = "", curves: Iterable[str] = (), language: str = "en",
    ) -> Picture:  # fmt: skip
        """Write the motion of the mechanism as a page (.html), or as .gif or .mp4; a notebook shows it.

        A page is one file without need of a network, in which one plays, stops, goes back and chooses curves;
        `frames`, `fps`, `dpi`, `power` and `stress` are for .gif and .mp4.  At most `frames` pictures, evenly spaced
        in time, shown at `fps` [1/s].  trace: points ("coupler.P") whose paths are drawn.  dpi: resolution [1/inch].
        speed: of the animation relative to the motion, 0.1 for ten times slower; of a .gif or .mp4 it sets the number
        of frames.  names: label the bodies with their names.  power: arrows show the power that goes through joints,
        and from drivers and loads, by their width.  stress: bars with section and material have the colour of their
        stress, and their moments beside them.  Of a page: title stands above it, instead of the name of the model;
        curves are those shown at first; language is that of its labels: "en", "de", "fr", "es" or "zh".
        Raises InputError for another suffix, a result without instants, an unknown curve or language, UnknownName,
        MissingProgram without ffmpeg.
        """
        if Path(path).suffix.lower() == ".html":
            from rattle.pages import replay
            from rattle.pages.wishes import Wishes

            replay.animate(
                self, path, trace=trace, names=names, speed=speed, wishes=Wishes(title, tuple(curves), True, language),
                film={"frames": frames != 120, "fps": fps != 20, "dpi": dpi != 90.0, "power": power, "stress": stress},
            )  # fmt: skip
            return Picture(Path(path))
        from rattle.plots import animation

        if title or tuple(curves) or language != "en":
            raise InputError("title, curves and language: only pages (.html) have them, leave them out")
        animation.animate(
            self, path, frames=frames, fps=fps, trace=trace, dpi=dpi, speed=speed, names=names, power=power,
            stress=stress,
        )  # fmt: skip
        return Picture(Path(path))


@answer_in_words
def load_result(path: str | os.PathLike[str]) -> Result:
    """Read a result that `Result.save` wrote (SI units).

    Raises FileNotFoundError, OSError if the file cannot be opened, MissingPackage (netCDF without h5py), and
    ValueError if the file is damaged or not a result of rattle.
    """
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
            breaks=Breaks.from_text(record["breaks"], len(record["names"])) if "breaks" in record else None,
        )
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise InputError(f"{path} {archive.NO_RESULT}") from error


# ---------------------------------------------------------------- pieces
def _frozen(values: ArrayLike) -> Array:
    view = np.asarray(values, dtype=np.float64).view()
    view.flags.writeable = False
    return view
