"""A study of wear in a folder: written after every jump, whole or not at all; the same call goes on there.

manifest.json       what it is a study of
state.npz           how far it has come, to the last bit
<joint>.wear.csv    profiles, as a model file reads them
history.csv         one row per jump
"""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rattle.atomic_file import atomic
from rattle.description.wear_profile import profile_text
from rattle.errors import InputError
from rattle.mechanism import Mechanism
from rattle.questions.ensemble.identity import python_laws
from rattle.questions.wear.cycle import Sliding, State
from rattle.questions.wear.pins import Depths, Pin, as_documents
from rattle.questions.wear.worn import Reached
from rattle.user_paths import expanded
from rattle.value_types import Tree
from rattle.version import __version__

FORMAT = 1
MANIFEST, STATE, HISTORY, MODEL = "manifest.json", "state.npz", "history.csv", "worn.toml"
GROWS = ("cycles",)  # settings that may change from call to call
LABELS = {"rattle": "version of rattle", "model": "model", "laws": "Python laws"}


class Folder:
    """Where a study is kept."""

    def __init__(
        self, path: str | os.PathLike[str], m: Mechanism, asked: Mapping[str, float], pins: Sequence[Pin]
    ) -> None:
        """Open a folder, made if it is not there.  Raises InputError for one of another study, OSError."""
        self.path, self._pins = expanded(path), pins
        if self.path.exists() and not self.path.is_dir():
            raise NotADirectoryError(f"{self.path} is a file; give the name of a folder")
        self.path.mkdir(parents=True, exist_ok=True)
        fixed = {key: repr(float(value)) for key, value in asked.items() if key not in GROWS}
        now = {"format": FORMAT, "kind": "wear", "rattle": __version__, "laws": python_laws(m.model),
               "model": m.to_toml(), **fixed}  # fmt: skip
        manifest = self.path / MANIFEST
        if manifest.exists():
            self._compare(_read(manifest), now)
            return
        others = sorted(entry.name for entry in self.path.iterdir() if not entry.name.startswith("."))
        if others:
            raise FileExistsError(
                f"{self.path} holds other files ({', '.join(others[:3])}{', ...' if others[3:] else ''}) and no"
                f" {MANIFEST}; give a new or an empty folder"
            )
        with atomic(manifest) as file:
            file.write_text(json.dumps(now, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")

    def _compare(self, before: Tree, now: Tree) -> None:
        if before.get("kind") != "wear" or before.get("format") != FORMAT:
            raise InputError(f"{self.path} holds another kind of study; give another folder")
        for key, value in now.items():
            if before.get(key) != value:
                what = LABELS.get(key, key)
                difference = "" if key in ("model", "laws") else f": {before.get(key)}, now {value}"
                raise InputError(
                    f"{self.path} holds another study, its {what} differs{difference}; give another folder"
                )

    def read(self) -> Reached | None:
        """How far the study has come; None if it has not begun.  Raises InputError for a damaged file."""
        place = self.path / STATE
        if not place.exists():
            return None
        try:
            with np.load(place, allow_pickle=False) as kept:
                depths = [kept[f"depths{n}"] for n in range(len(self._pins))]
                lost = [kept[f"lost{n}"] for n in range(len(self._pins))]
                cycle, t, next_, simulated, seen = (float(number) for number in kept["numbers"])
                state = State(t, kept["y"], kept["speeds"])
                rows = kept["rows"].tolist()
                self._check(depths, lost, state)
                pins = range(len(self._pins))
                works = [[kept[f"work{k}.{n}"] for n in pins] for k in range(int(seen))]
                loads = [[kept[f"loads{k}.{n}"] for n in pins] for k in range(int(seen))]
                shares = [kept[f"shares{k}"] for k in range(int(seen))]
                recent = [Sliding(*parts, state) for parts in zip(works, loads, shares, strict=True)]
                outcome = str(kept["outcome"])
                return Reached(depths, cycle, state, recent, next_, int(simulated), outcome, rows, lost)
        except (OSError, EOFError, KeyError, TypeError, ValueError, zipfile.BadZipFile) as error:
            raise InputError(f"{place} is damaged ({error}); remove it to begin anew") from None

    def _check(self, depths: Depths, lost: Depths, state: State) -> None:
        """Raise InputError for depths of other sizes, and for what is not a number."""
        for pin, *both in zip(self._pins, depths, lost, strict=True):
            if any(array.shape != (2, pin.bins) for array in both):
                raise InputError(f"depths of {pin.joint} do not have {pin.bins} bins")
        if not all(np.isfinite(array).all() for array in (*depths, *lost, state.y, state.speeds, np.array(state.t))):
            raise InputError("it has values that are not numbers")

    def write(self, reached: Reached) -> None:
        """Keep how far the study has come."""
        arrays: dict[str, Any] = {f"depths{n}": array for n, array in enumerate(reached.depths)}
        arrays |= {f"lost{n}": array for n, array in enumerate(reached.per_cycle)}
        for k, seen in enumerate(reached.recent):
            arrays |= {f"work{k}.{n}": array for n, array in enumerate(seen.work)}
            arrays[f"shares{k}"] = seen.shares
            arrays |= {f"loads{k}.{n}": array for n, array in enumerate(seen.loads)}
        state = reached.state
        assert state is not None, "kept after a jump"
        numbers = np.array([reached.cycle, state.t, reached.next, reached.simulated, len(reached.recent)])
        with atomic(self.path / STATE) as file, file.open("wb") as open_file:
            np.savez(
                open_file,
                outcome=np.array(reached.outcome),
                y=state.y,
                speeds=state.speeds,
                numbers=numbers,
                rows=np.array(reached.rows),
                **arrays,
            )
        for joint, depths in as_documents(self._pins, reached.depths).items():
            with atomic(self.path / f"{joint}.wear.csv") as file:
                file.write_text(profile_text(joint, depths), encoding="utf-8")

    def finish(self, mechanism: Mechanism, columns: Tree) -> None:
        """Write what others read: the history and the worn mechanism."""
        lines = [
            ",".join(columns),
            *(",".join(map(repr, map(float, row))) for row in zip(*columns.values(), strict=True)),
        ]
        with atomic(self.path / HISTORY) as file:
            file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        mechanism.save(self.path / MODEL)


def _read(manifest: Path) -> dict[str, Any]:
    try:
        return dict(json.loads(manifest.read_text(encoding="utf-8")))
    except (OSError, TypeError, ValueError) as error:
        raise InputError(f"{manifest} cannot be read ({error}); give another folder") from None
