"""Spectra of curves: which frequencies a force or motion has, and which multiples of the driver's turning they are."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from rattle.errors import InputError
from rattle.plots.curves import axis_label, figure_of, new_axes, note, panel_of, title_of
from rattle.results.handy_units import QUANTITY, handy_unit
from rattle.results.spectrum import amplitude_spectrum, steady_turns

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.result import Result

SMALLEST = 1e-4  # amplitude that is shown, as a share of the largest of its panel
QUIET = 1e-3  # the axis ends where all amplitudes of the first result stay below this share of the largest


def plot_spectrum(result: Result, *names: str, compare: Iterable[tuple[str, Result]] = ()) -> Figure:
    """See `Result.plot_spectrum`."""
    if not names:
        raise InputError(f"name at least one curve, such as {', '.join(repr(n) for n in result.names[:3])}")
    panels: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        panels.setdefault(result.unit(name), []).append(name)
    others = list(compare)
    axes = new_axes(8.0, 1.3 + 2.2 * len(panels), rows=len(panels))
    loud = 0.0
    for ax, (unit, curves) in zip(axes, panels.items(), strict=True):
        spectra = [amplitude_spectrum(result.t, result[name]) for name in curves]
        largest = max(float(a.max()) for _, a in spectra)
        factor, shown = handy_unit(unit, largest)
        panel_of(ax, result, curves, others, lambda r, name: amplitude_spectrum(r.t, r[name]), factor)
        if largest > 0.0:
            ax.set_yscale("log")
            least = min(float(a.min()) for _, a in spectra)
            ax.set_ylim(factor * max(SMALLEST * largest, 0.7 * least), 1.5 * factor * largest)
        ax.set_ylabel(axis_label(f"amplitude of\n{QUANTITY[unit]}" if unit in QUANTITY else "amplitude", shown))
        loud = max([loud, *(_end(f, a, largest) for f, a in spectra)])
    frequencies = amplitude_spectrum(result.t, result[next(iter(names))])[0]
    end = min(float(frequencies[-1]), max(1.15 * loud, 20.0 * float(frequencies[0])))
    axes[-1].set_xlim(0.0, end)
    axes[-1].set_xlabel("frequency [Hz]")
    _orders(axes[0], result)
    title_of(axes[0], result)
    note(axes[-1], f"Hann window, mean taken out, resolution {frequencies[0]:.3g} Hz")
    return figure_of(axes[0])


def _end(f: np.ndarray, amplitude: np.ndarray, largest: float) -> float:
    """The highest frequency [Hz] at which something is heard."""
    heard = np.flatnonzero(amplitude > QUIET * largest)
    return float(f[heard[-1]]) if len(heard) else 0.0


def _orders(ax: Axes, result: Result) -> None:
    """A second axis with multiples of the turning speed of the first driver that turns steadily."""
    joint, turns = _steady(result)
    if turns > 0.0:
        top = ax.secondary_xaxis(
            "top", functions=(lambda f: np.asarray(f) / turns, lambda order: np.asarray(order) * turns)
        )
        top.set_xlabel(f"order: multiple of the {turns:.4g} turns/s of {joint}", fontsize=9, parse_math=False)


def _steady(result: Result) -> tuple[str, float]:
    """The first driven joint that turns steadily and its turns per second; 0 if there is none."""
    for joint in result.geometry["driven"]:
        a, b = result.geometry["joints"][joint]["bodies"]
        speed = np.zeros(len(result.t))
        for body, sign in ((a, -1.0), (b, 1.0)):
            speed = speed + sign * result[f"{body}.omega"] if f"{body}.omega" in result else speed
        turns = steady_turns(result.t, speed)
        if turns > 0.0:
            return joint, turns
    return "", 0.0
