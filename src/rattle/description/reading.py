"""The one door through which everything is read: whatever goes wrong there becomes a problem at its place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import TracebackType

from rattle.errors import InputError

# what Python and NumPy raise where numbers or shapes do not fit; LinAlgError is a ValueError
FAULTS = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)

Path = tuple[str | int, ...]
Table = Mapping[str, object]  # of a document, as it is written


def section(table: Table, key: str) -> Table:
    """A table inside of another one; an empty one where there is none."""
    inner = table.get(key)
    return inner if isinstance(inner, Mapping) else {}


class Place:
    """While something is read: a fault inside becomes a problem at this path, and reading goes on behind it.

    Places lie inside of each other, as entries and their fields do; the innermost answers.  tell(path, message) takes
    an answer of ours, unforeseen(path, error) any other error.
    """

    __slots__ = ("path", "tell", "unforeseen")

    def __init__(
        self, path: Path, tell: Callable[[Path, str], None], unforeseen: Callable[[Path, Exception], None]
    ) -> None:
        self.path, self.tell, self.unforeseen = path, tell, unforeseen

    def __enter__(self) -> None:
        """Nothing is prepared."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        if isinstance(error, InputError):
            self.tell(self.path, str(error))
        elif isinstance(error, FAULTS):
            self.unforeseen(self.path, error)
        else:
            return False
        return True


def unforeseen_words(error: Exception) -> str:
    """What is said of an error that no reader has foreseen."""
    return f"cannot be used as it is written ({error or type(error).__name__}); are its numbers as meant?"
