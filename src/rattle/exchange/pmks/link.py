"""The text of a link of PMKS+ as records.

    flags.scale.speed,step.units.joint.joint. .link.link. .force. .selection check

Numbers are written in 64 digits, 0-9 A-Z a-z _ -, with a leading 0 for a minus; decimals are thousandths.  The last
character is the check: digit number (length of the rest) mod 62.  Older links end behind links or forces.
"""

from __future__ import annotations

import re
from typing import NamedTuple
from urllib.parse import unquote

from rattle.exchange.refusal import quoted, refused

DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-"
CHECKS = DIGITS[:62]
VALUES = {digit: n for n, digit in enumerate(DIGITS)}
LENGTHS = (("in", 254, 10_000), ("cm", 1, 100), ("m", 1, 1))  # units: name, and [m] as a fraction
LONGEST_NUMBER = 10  # digits
LONGEST = 60_000  # characters of a link: a thousand bodies; pages take less
THOUSANDTHS = 1000
CLOCKWISE, GRAVITY = 0, 1  # of the flags in front
OF_JOINT = ("x", "y", "angle")
OF_PIECE = ("mass", "inertia", "x of the mass centre", "y of the mass centre")
PRISMATIC, INPUT, GROUNDED, WELDED = range(4)  # of the flags of a joint


class Decimal(NamedTuple):
    """A number of a link, in thousandths, as it is written there."""

    thousandths: int

    def times(self, over: int, under: int) -> float:
        """The number times a fraction, correctly rounded."""
        return self.thousandths * over / (THOUSANDTHS * under)


class Place(NamedTuple):
    """A joint of a link: a place where bodies meet."""

    id: str
    name: str
    x: Decimal
    y: Decimal
    angle: Decimal  # of a slider [rad]
    flags: int

    def has(self, flag: int) -> bool:
        """True if it is so: PRISMATIC, INPUT, GROUNDED or WELDED."""
        return bool(self.flags >> flag & 1)


class Piece(NamedTuple):
    """A link of a link: a body, or a part of one that is welded."""

    root: bool  # a body, not only a part of one
    piston: bool
    id: str
    name: str
    mass: Decimal  # [kg]
    inertia: Decimal  # [kg m^2]
    center: tuple[Decimal, Decimal]
    joints: tuple[str, ...]
    parts: tuple[str, ...]


class Link(NamedTuple):
    """The whole text."""

    unit: tuple[str, int, int]
    speed: int  # rpm of a motor, units of length per second of a slider that is driven
    flags: int
    joints: tuple[Place, ...]
    pieces: tuple[Piece, ...]
    forces: tuple[str, ...]


def link_text(text: str, file: str) -> str:
    """The link in a file: behind pmks: or the question mark of an address.  Raises ModelError."""
    if len(text) > LONGEST:
        raise refused(file, f"a link of {len(text)} characters; at most {LONGEST} are read")
    lines = [line.strip() for line in text.lstrip("\ufeff").splitlines()]
    lines = [line.removeprefix("URL=") for line in lines if line and line != "[InternetShortcut]"]
    if len(lines) != 1:
        raise refused(file, f"expected one link of PMKS+, pmks: and the link or an address, got {len(lines)} lines")
    (line,) = lines
    if line[:5].lower() == "pmks:":
        link = line[5:].strip().lstrip("?")
        return link if _checks(link) or "%" not in link else unquote(link)
    if re.match(r"https?://", line, re.IGNORECASE):
        if "?" not in line:
            raise refused(file, "the address has no mechanism: nothing stands behind a question mark", 1)
        return unquote(line.partition("?")[2])
    raise refused(file, f"not a link of PMKS+: it begins with {quoted(line)}; expected pmks: or an address", 1)


def _checks(link: str) -> bool:
    units = len(link[:-1].encode("utf-16-le", "surrogatepass")) // 2  # as the page counts characters
    return bool(link) and link[-1] == CHECKS[units % len(CHECKS)]


def read_link(link: str, file: str) -> Link:
    """Read a link.  Raises ModelError."""
    if not link:
        raise refused(file, "the link is empty", 1)
    if not _checks(link):
        fault = f"the last character, {quoted(link[-1])}, does not check: the link is incomplete or was changed"
        raise refused(file, fault, 1)
    return _Reader(link[:-1], file).read()


class _Reader:
    def __init__(self, rest: str, file: str) -> None:
        self.rest = rest
        self.file = file

    def read(self) -> Link:
        """All of it, from left to right."""
        flags = self.flags(self.token(), "settings")
        self.token()  # size of the symbols
        speed = self.whole(self.token().split(",")[0], "speed of the input")
        units = self.token()
        if not units or units[0] not in DIGITS[: len(LENGTHS)]:
            raise self.refused(f"its unit of length, {quoted(units[:1])}, is none of in, cm, m")
        joints = tuple(self.joint(n, text) for n, text in enumerate(self.section("joints"), 1))
        pieces = tuple(self.piece(n, text) for n, text in enumerate(self.section("links"), 1))
        forces = tuple(self.force(n, text, pieces) for n, text in enumerate(self.section("forces", last=True), 1))
        self.require_different([joint.id for joint in joints], "joints")
        self.require_different([piece.id for piece in pieces], "links")
        self.require_known(joints, pieces)
        return Link(LENGTHS[VALUES[units[0]]], speed, flags, joints, pieces, forces)

    def refused(self, message: str) -> Exception:
        """The error to raise."""
        return refused(self.file, message, 1)

    def token(self) -> str:
        """The text up to the next full stop."""
        token, dot, self.rest = self.rest.partition(".")
        if not dot:
            raise self.refused(f"it ends within its settings, behind {quoted(token[-20:])}")
        return token

    def section(self, what: str, last: bool = False) -> list[str]:
        """Texts up to an empty one; last: which may be missing."""
        texts = []
        while self.rest and not self.rest.startswith("."):
            text, _, self.rest = self.rest.partition(".")
            texts.append(text)
        if not self.rest and not last:
            raise self.refused(f"it ends within its {what}")
        self.rest = self.rest[1:]
        return texts

    # ------------------------------------------------------------ numbers
    def whole(self, text: str, what: str) -> int:
        """A whole number."""
        digits = text[1:] if text.startswith("0") and len(text) > 1 else text
        if not digits or len(digits) > LONGEST_NUMBER or any(digit not in VALUES for digit in digits):
            raise self.refused(f"{what}: {quoted(text)} is not a number")
        number = 0
        for digit in digits:
            number = number * len(DIGITS) + VALUES[digit]
        return -number if len(digits) < len(text) else number

    def decimal(self, text: str, what: str) -> Decimal:
        """A number in thousandths."""
        return Decimal(self.whole(text, what))

    def flags(self, text: str, what: str) -> int:
        """Bits, the first one last."""
        number = 0
        if not text or len(text) > LONGEST_NUMBER or any(digit not in VALUES for digit in text):
            raise self.refused(f"{what}: {quoted(text)} are not flags")
        for digit in text:
            number = number * len(DIGITS) + VALUES[digit]
        return number

    # ------------------------------------------------------------ parts
    def joint(self, n: int, text: str) -> Place:
        """flags, id, name, x, y, angle"""
        of, fields = f"joint {n}", text[1:].split(",")
        if len(fields) != 5 or not fields[0]:
            raise self.refused(f"{of}: expected id, name, x, y and angle, got {quoted(text)}")
        name = f"joint {fields[1] or fields[0]}"
        x, y, angle = (self.decimal(field, f"{name}: {what}") for field, what in zip(fields[2:], OF_JOINT, strict=True))
        return Place(fields[0], fields[1] or fields[0], x, y, angle, self.flags(text[:1], name))

    def piece(self, n: int, text: str) -> Piece:
        """Y or N, R or P, id, name, mass, inertia, x, y, colour, joints, nothing, parts"""
        of, fields = f"link {n}", text[2:].split(",")
        if text[:1] not in ("Y", "N") or text[1:2] not in ("R", "P") or len(fields) < 8 or not fields[0]:
            raise self.refused(f"{of}: expected its kind, id, name, mass, inertia, x, y and joints, got {quoted(text)}")
        name = fields[1] or fields[0]
        numbers = zip(fields[2:6], OF_PIECE, strict=True)
        mass, inertia, x, y = (self.decimal(field, f"link {name}: {what}") for field, what in numbers)
        if mass.thousandths < 0 or inertia.thousandths < 0:
            raise self.refused(f"link {name}: its mass or inertia is negative")
        rest = fields[7:]
        end = rest.index("") if "" in rest else len(rest)
        parts = tuple(part for part in rest[end:] if part)
        return Piece(
            text[0] == "Y", text[1] == "P", fields[0], name, mass, inertia, (x, y), tuple(rest[:end]), parts
        )  # fmt: skip

    def force(self, n: int, text: str, pieces: tuple[Piece, ...]) -> str:
        """Its name; flags, id, link, name, two places, size."""
        fields = text[1:].split(",")
        if len(fields) != 8:
            raise self.refused(f"force {n}: expected id, link, name, two places and a size, got {quoted(text)}")
        name = fields[2] or fields[0]
        if fields[1] not in {piece.id for piece in pieces}:
            raise self.refused(f"force {name}: there is no link {quoted(fields[1])}")
        for field in fields[3:]:
            self.decimal(field, f"force {name}")
        return name

    # ------------------------------------------------------------ references
    def require_different(self, ids: list[str], what: str) -> None:
        """Refuse two things of one id."""
        seen: set[str] = set()
        for name in ids:
            if name in seen:
                raise self.refused(f"two {what} have the id {quoted(name)}")
            seen.add(name)

    def require_known(self, joints: tuple[Place, ...], pieces: tuple[Piece, ...]) -> None:
        """Refuse references that lead nowhere, and links without a mechanism."""
        places, bodies = {joint.id for joint in joints}, {piece.id for piece in pieces}
        for piece in pieces:
            for joint in piece.joints:
                if joint not in places:
                    raise self.refused(f"link {piece.name}: there is no joint {quoted(joint)}")
            for part in piece.parts:
                if part not in bodies:
                    raise self.refused(f"link {piece.name}: there is no link {quoted(part)}, which is a part of it")
            if not piece.joints:
                raise self.refused(f"link {piece.name} has no joint")
        if not any(piece.root for piece in pieces):
            raise self.refused("it has no link: there is no mechanism in it")
