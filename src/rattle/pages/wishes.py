"""What one may wish of any page: its title, the curves that it shows first, and its language."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from rattle.errors import InputError, suggest
from rattle.pages.measured_data import units_of
from rattle.pages.words import ENGLISH, in_language
from rattle.value_types import Tree


class Wishes(NamedTuple):
    """What a page is wished to be; nothing of it must be."""

    title: str = ""  # instead of the name of the model
    curves: Sequence[str] = ()  # that are shown at first, instead of those that say most
    trust: bool = True  # whether the reasons for the trust in a run can be read
    language: str = ENGLISH

    def of(self, scene: Tree) -> dict[str, Any]:
        """A scene as it is wished.  Raises InputError for a curve or a language that is not there."""
        _require_curves(scene, self.curves)
        show = dict(scene["show"])
        if self.curves:
            show["curves"] = list(self.curves)
        if not self.trust:
            show["trust"] = False
        return in_language({**scene, "show": show, "title": self.title or scene["title"]}, self.language)


AS_USUAL = Wishes()


def _require_curves(scene: Tree, curves: Sequence[str]) -> None:
    """Raise InputError for a curve that the motions of a page do not have."""
    present = list(units_of(scene))
    for name in curves:
        if name not in present:
            raise InputError(f"the motion has no curve '{name}'{suggest(name, present)}")
