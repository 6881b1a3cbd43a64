"""Questions: what may be asked of a mechanism or of a result, each declared once, in a folder of `rattle.questions`.

A question is a function with a true signature:

    @question(
        asks="Largest pressure angle of every cam, and where the cam is then.",
        wants="whether a cam pushes its follower sideways",
        arguments={"points": Argument("Number of positions over a turn", at_least=2)},
    )
    def pressure_angle(m: Mechanism, points: int = 361) -> Answer: ...

From this alone come the method `m.pressure_angle()`, the command `rattle pressure-angle FILE` with its options and
`--json`, the tab and form of the studio, the section of the report, the card of a notebook, the row in "Which analysis
do I need?", and its use in ensembles and sweeps (`analysis="pressure-angle"`).  Where the usual one does not do, a
module of the folder is used instead: see PARTS.

Questions of one's own stand in folders which the environment variable RATTLE_QUESTIONS names, separated as in PATH, one
folder with an `__init__.py` per question: docs/adding-a-question.md.
"""

from __future__ import annotations

import functools
import importlib
import importlib.util
import inspect
import os
import pkgutil
from collections.abc import Callable, Mapping
from pathlib import Path
from threading import get_ident
from types import ModuleType
from typing import Any, NamedTuple, TypeVar

from rattle.errors import InputError
from rattle.user_paths import expanded

ROOM = "rattle.questions"
FOLDERS = "RATTLE_QUESTIONS"  # environment variable: further folders of questions
OF_THE_CALLER = ("progress",)  # arguments that whoever asks gives by itself
SEVERAL = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD
# names of options that commands have anyway, and of what tabs hand on
OF_EVERY_QUESTION = {
    "file", "set", "ideal", "without", "laws", "output", "json", "quiet", "units", "help", "shelf", "source",
}  # fmt: skip
PLACE_OF_ANSWERS = 75  # of tabs of answers in blocks, before the report
OWN_ORDER = 1000  # of questions that do not say where they stand: after all others
# modules that a question's folder may hold, and what stands in each
PARTS = {
    "command": "`command`: the click command, in place of one made from the signature",
    "tab": "`tab(shelf, source, **options)`: the content of the studio's tab",
    "section": "`SECTIONS`, places in the report with functions of the study, and `gather`, `headline`, `holds`",
    "samples": "`ANALYSIS`: how ensembles, sweeps and tolerances ask it of each sample",
}
F = TypeVar("F", bound=Callable[..., Any])


class Argument(NamedTuple):
    """One argument of a question, as option, field of a form and part of a docstring."""

    means: str  # in one line
    unit: str = ""  # SI; values may then be given as quantities such as "5 mm"
    choices: tuple[str, ...] = ()
    at_least: float | None = None
    offers: str = ""  # names that a form suggests: "curves", "joints", "bodies", "loads" or "parameters"


class FormField(NamedTuple):
    """A field in the form of a tab; what is written into it goes to the tab under its key."""

    key: str
    label: str
    value: str = ""  # at first
    usual: str = ""  # what the page puts there at first: "output", "force" or "dimensions" of the model
    choices: tuple[str, ...] = ()  # a list to choose from
    offers_curves: bool = False  # suggests names of curves
    needs: str = ""  # it is there only where the model has such joints: "wear" or "oil"
    size: int = 18  # [characters]
    means: str = ""  # in one line


class Tab(NamedTuple):
    """A tab of the studio."""

    name: str
    title: str
    place: int  # among all tabs
    fields: tuple[FormField, ...] = ()


class Question(NamedTuple):
    """What is declared of a question; its words, and the function that answers it."""

    name: str  # of the method
    answer: Callable[..., Any]  # of a mechanism or a result, and the arguments
    package: str  # its folder, as a package
    asks: str  # one line, for lists of commands
    of: str  # "mechanism" or "result"
    command: str  # name of its command, "" for none
    title: str  # of its tab and its section
    wants: tuple[tuple[str, str], ...]  # rows of "Which analysis do I need?": what you want to know, how it is called
    examples: tuple[tuple[str, str], ...]  # for each of them: on the command line, in Python
    order: int  # its place in lists
    arguments: Mapping[str, Argument]
    shows_quantities: bool  # the command has --units
    own_tab: Tab | None  # what its part `tab` fills
    in_blocks: bool = False  # it returns an heir of `Answer`

    @property
    def written(self) -> str:
        """Its name as the analysis of ensembles and sweeps, and on the command line."""
        return self.name.replace("_", "-")

    def part(self, name: str) -> ModuleType | None:
        """A module of its folder, see PARTS; None if it has none."""
        module = f"{self.package}.{name}"
        return importlib.import_module(module) if importlib.util.find_spec(module) is not None else None

    def has(self, name: str) -> bool:
        """True if its folder holds this part; nothing is imported."""
        return importlib.util.find_spec(f"{self.package}.{name}") is not None

    @property
    def tab(self) -> Tab | None:
        """Its tab in the studio: its own, or one for an answer in blocks with a field for every argument."""
        if self.own_tab is not None or not self.answers_in_blocks:
            return self.own_tab
        return Tab(self.name, self.title, PLACE_OF_ANSWERS, tuple(map(self._field, self.takes)))

    def _field(self, name: str) -> FormField:
        argument, usual = self.arguments.get(name, Argument("")), self.usual.get(name)
        unit = f" [{argument.unit}]" if argument.unit else ""
        return FormField(
            name, f"{name.replace('_', ' ')}{unit}", "" if usual is None else str(usual), choices=argument.choices,
            offers_curves=argument.offers == "curves", means=argument.means,
        )  # fmt: skip

    @property
    def takes(self) -> tuple[str, ...]:
        """Its arguments after the mechanism or result, but those that whoever asks gives by itself."""
        return tuple(name for name in _parameters(self.answer) if name not in OF_THE_CALLER)

    @property
    def usual(self) -> dict[str, Any]:
        """Arguments that may be left out, with their values."""
        every = _parameters(self.answer).items()
        return {name: parameter.default for name, parameter in every if parameter.default is not parameter.empty}

    @property
    def needed(self) -> tuple[str, ...]:
        """Arguments that it cannot do without."""
        return tuple(name for name in self.takes if name not in self.usual)

    @property
    def answers_in_blocks(self) -> bool:
        """True if it returns an `Answer`, from which everything it shows is made, or says that it does."""
        if self.in_blocks:
            return True
        returned = self.answer.__annotations__.get("return", "")
        return str(getattr(returned, "__name__", returned)).rpartition(".")[2] == "Answer"


def _parameters(answer: Callable[..., Any]) -> dict[str, inspect.Parameter]:
    """Those after the mechanism or result, without *names and **names."""
    every = list(inspect.signature(answer).parameters.values())[1:]
    return {parameter.name: parameter for parameter in every if parameter.kind not in SEVERAL}


_declared: dict[str, Question] = {}
_places: dict[str, str] = {}  # where each folder of a question stands
_readers: set[int] = set()  # threads that read declarations just now
_askable: dict[str, type] = {}  # classes whose methods questions are, by what they are asked of


def question(
    *, asks: str, wants: str | tuple[tuple[str, str], ...] = (), examples: tuple[tuple[str, str], ...] = (),
    of: str = "mechanism", command: str | None = None, title: str = "", order: int = OWN_ORDER,
    arguments: Mapping[str, Argument] | None = None, shows_quantities: bool = True, tab: Tab | None = None,
    in_blocks: bool = False,
) -> Callable[[F], F]:  # fmt: skip
    """Decorator: declares a question; arguments as in `Question`.

    wants: a text, or for each row of the table what you want to know and how the analysis is called, as Markdown.
    command: default the name of the function with - for _.  title: default the name with spaces.
    in_blocks: the function returns a class that inherits from `Answer`.
    Raises InputError for a name that is taken, or arguments that the function does not have.
    """

    def declare(function: F) -> F:
        name = function.__name__
        words = name.replace("_", " ")
        if name in _declared and _declared[name].package != function.__module__:
            raise InputError(
                f"question '{name}' is declared twice, in {_declared[name].package} and {function.__module__}; rename"
                " one of them"
            )
        takes = _parameters(function)
        unknown = sorted(set(arguments or {}) - set(takes))
        if unknown:
            raise InputError(f"question '{name}' has no argument {', '.join(unknown)}; it has {', '.join(takes)}")
        called = name.replace("_", "-") if command is None else command
        if called and any(other.command == called for other in _declared.values() if other.name != name):
            raise InputError(f"question '{name}': there is a command {called} already; give another one by command=")
        declared = Question(
            name, function, function.__module__, asks, of, called,
            title or words[0].upper() + words[1:], ((wants, words),) if isinstance(wants, str) else wants, examples,
            order, arguments or {}, shows_quantities, tab, in_blocks,
        )  # fmt: skip
        if declared.answers_in_blocks and (taken := sorted(OF_EVERY_QUESTION & set(takes))):
            raise InputError(f"question '{name}': {', '.join(taken)} means something already; rename the argument")
        _declared[name] = declared
        return function

    return declare


def questions() -> Mapping[str, Question]:
    """All questions by name, in their order; while those of one's own are read, the ones that are known by then.

    Raises InputError for a folder of one's own that is none, or whose declarations cannot be read.
    """
    return _in_order() if get_ident() in _readers else _every()


@functools.cache
def _every() -> Mapping[str, Question]:
    _read_shipped()
    _readers.add(get_ident())
    try:
        for folder in filter(None, os.environ.get(FOLDERS, "").split(os.pathsep)):
            _read_folder(folder)
    finally:
        _readers.discard(get_ident())
    _give_methods()
    return _in_order()


def _in_order() -> dict[str, Question]:
    return dict(sorted(_declared.items(), key=lambda entry: (entry[1].order, entry[0])))


@functools.cache
def _read_shipped() -> None:
    for module in pkgutil.iter_modules(importlib.import_module(ROOM).__path__):
        if module.ispkg:
            _places[module.name] = "rattle"
            importlib.import_module(f"{ROOM}.{module.name}")


def _read_folder(written: str) -> None:
    """Import the declarations of a folder of one's own."""
    folder = os.path.abspath(expanded(written))
    if not Path(folder).is_dir():
        raise InputError(f"{FOLDERS}: there is no folder {written}")
    importlib.import_module(ROOM).__path__.append(folder)
    for module in pkgutil.iter_modules([folder]):
        if module.ispkg and _places.setdefault(module.name, folder) != folder:
            raise InputError(
                f"{FOLDERS}: {written} holds {module.name}, and so does {_places[module.name]}; rename one of them"
            )
        if module.ispkg:
            _read_own(module.name, Path(folder))


def _read_own(name: str, folder: Path) -> None:
    try:
        importlib.import_module(f"{ROOM}.{name}")
    except InputError:
        raise
    except Exception as error:  # whatever stands there
        raise InputError(f"{FOLDERS}: {folder / name} cannot be read: {type(error).__name__}: {error}") from error


def methods_of(**askable: type) -> None:
    """From now on these classes have every question of a "mechanism" or a "result" as a method.

    Those of one's own come with the next call of `questions`: they may import whatever is imported just now.
    """
    _askable.update(askable)
    _read_shipped()
    _give_methods()


def _give_methods() -> None:
    for name, asked in _declared.items():
        if asked.of in _askable:
            setattr(_askable[asked.of], name, asked.answer)
    heir: type
    for asker in _askable.values():
        for heir in type.__subclasses__(asker):
            require_free_names(heir)


def require_free_names(heir: type) -> None:
    """Raise InputError if a class that inherits questions has another method of the name of one."""
    for name, asked in _declared.items():
        others = [vars(base)[name] for base in heir.__mro__ if name in vars(base)]
        if asked.of in _askable and issubclass(heir, _askable[asked.of]) and any(
            getattr(other, "__wrapped__", other) is not asked.answer for other in others
        ):  # fmt: skip
            raise InputError(f"question '{name}': a {asked.of} has a method {name} already; rename the question")


def asked_of(what: str) -> dict[str, Question]:
    """The questions that are asked of a "mechanism" or a "result"."""
    return {name: asked for name, asked in questions().items() if asked.of == what}


def analysis_names() -> tuple[str, ...]:
    """The questions that ensembles, sweeps and tolerances may ask of each sample, as they are written."""
    asked = asked_of("mechanism").values()
    return tuple(each.written for each in asked if each.has("samples") or (each.answers_in_blocks and not each.needed))


def tabs() -> list[tuple[Question, Tab]]:
    """The questions that have a tab in the studio, in the order of their tabs."""
    filled = [(asked, tab) for asked in questions().values() if (tab := asked.tab) is not None]
    return sorted(filled, key=lambda entry: (entry[1].place, entry[1].name))
