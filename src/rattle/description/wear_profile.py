"""Files of wear profiles: the depths of bush and pin of one joint, beside the model file."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from rattle.description.changes import Change
from rattle.description.read_tables import inside, rows_of, text_of
from rattle.description.read_values import quoted
from rattle.description.reading import Table, section
from rattle.description.tables import DEPTHS
from rattle.errors import InputError, ModelError, Problem

HEADER = ("angle [rad]", "bush [m]", "pin [m]")
TITLE = "# wear profile of joint "


def with_profiles(document: Table, folder: Path | None, file: str = "", read: Table | None = None) -> dict[str, object]:
    """A document in which the joints that name a file of their profile hold its depths too.

    folder: that of the model file, None for a model that was not read from a file.  read: joints read before, whose
    depths stay as they are.  Raises ModelError with all problems.
    """
    joints, changed, problems = document.get("joints"), dict(document), list[Problem]()
    if not isinstance(joints, Mapping):
        return changed
    filled = dict(joints)
    for name, joint in joints.items():
        wear = joint.get("wear") if isinstance(joint, Mapping) else None
        if not isinstance(wear, Mapping) or "profile" not in wear:
            continue
        if DEPTHS in wear and read is None:
            problems.append(Problem(("joints", name, "wear", DEPTHS), "give a profile or depths, not both", True))
            continue
        before = section(section(read or {}, name), "wear")
        if DEPTHS in wear and before.get("profile") == wear["profile"]:
            continue
        try:
            depths = _of_file(wear["profile"], folder, name)
        except ValueError as error:
            problems.append(Problem(("joints", name, "wear", "profile"), str(error)))
            continue
        filled[name] = {**joint, "wear": {**wear, DEPTHS: depths}}
    if problems:
        raise ModelError(problems, file)
    return {**changed, "joints": filled}


def _of_file(profile: object, folder: Path | None, joint: str) -> dict[str, list[float]]:
    """Depths by side [m].  Raises InputError that says what is wrong with the file."""
    if not isinstance(profile, str) or not profile.strip():
        raise InputError(f'expected a file beside the model file, such as "pin.wear.csv", got {quoted(profile)}')
    if folder is None:
        raise InputError(f"{quoted(profile)}: a model that was not read from a file has no folder")
    return parsed(text_of(inside(folder, profile), profile), profile, joint)


def parsed(text: str, name: str, joint: str) -> dict[str, list[float]]:
    """Depths by side [m] from the text of a profile.  Raises InputError with the line."""
    lines = text.splitlines()
    whose = lines[0].removeprefix(TITLE).strip() if lines and lines[0].startswith(TITLE) else ""
    if not whose:
        raise InputError(f"{quoted(name)} is not a wear profile: its first line is not '{TITLE}NAME'")
    if whose != joint:
        raise InputError(f"{quoted(name)} is the wear profile of joint '{whose}', not of '{joint}'")
    rows = [
        (number, row) for number, row in enumerate(rows_of(text, name), start=1) if row and not row[0].startswith("#")
    ]
    if not rows or tuple(cell.strip() for cell in rows[0][1]) != HEADER:
        raise InputError(f"{quoted(name)} needs the columns {', '.join(HEADER)}")
    depths: dict[str, list[float]] = {"bush": [], "pin": []}
    for number, row in rows[1:]:
        try:
            angle, bush, pin = (float(cell) for cell in row)
        except ValueError:
            raise InputError(f"{name}, line {number}: expected three numbers") from None
        expected = (len(depths["bush"]) + 0.5) * 2.0 * math.pi / (len(rows) - 1)
        if not abs(angle - expected) < 1e-6:
            raise InputError(f"{name}, line {number}: expected the angle {expected:.9g}: bins of equal width in order")
        depths["bush"].append(bush)
        depths["pin"].append(pin)
    return depths


def written(
    joints: Table, stays: Callable[[str], bool], beside: bool
) -> tuple[dict[str, object], list[Change], dict[str, str]]:
    """Joints as they are written, the changes to the text, and the files that hold their profiles, by name.

    stays: whether the file of a profile is still found under this name; beside: others get files of their own,
    otherwise their depths are written out.
    """
    rewritten, changes, files = dict(joints), list[Change](), dict[str, str]()
    for name, joint in joints.items():
        wear = joint.get("wear") if isinstance(joint, Mapping) else None
        if not isinstance(wear, Mapping) or DEPTHS not in wear:
            continue
        if "profile" in wear and stays(wear["profile"]):
            table = {key: value for key, value in wear.items() if key != DEPTHS}
        elif beside:
            file = f"{name}.wear.csv"
            table = {**{key: value for key, value in wear.items() if key != DEPTHS}, "profile": file}
            files[file] = profile_text(name, _whole(wear[DEPTHS]))
            changes.append((("joints", name, "wear"), table))
        else:
            table = {key: value for key, value in wear.items() if key != "profile"}
            if "profile" in wear:
                changes.append((("joints", name, "wear"), table))
        rewritten[name] = {**section(joints, name), "wear": table}
    return rewritten, changes, files


def _whole(depths: Mapping[str, Sequence[float]]) -> dict[str, Sequence[float]]:
    """Depths of both sides, of which one may have been left out."""
    bins = max(len(row) for row in depths.values())
    return {side: depths.get(side, [0.0] * bins) for side in ("bush", "pin")}


def profile_text(joint: str, depths: Mapping[str, Sequence[float]]) -> str:
    """The text of a profile, to the last bit; angles are those of the middles of the bins, each in its body's frame."""
    out = io.StringIO()
    n = len(depths["bush"])
    out.write(f"{TITLE}{joint}\n# angles in the frame of the body with the bush, and of that with the pin\n")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEADER)
    for i, (bush, pin) in enumerate(zip(depths["bush"], depths["pin"], strict=True)):
        writer.writerow([repr((i + 0.5) * 2.0 * math.pi / n), repr(float(bush)), repr(float(pin))])
    return out.getvalue()
