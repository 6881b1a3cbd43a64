"""One session of the studio: its model text, what is computed of it, and what its page asks for.

The text of the model file is the truth; knobs change the text.  Everything here runs in the thread of the page.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from rattle.description import file as model_file
from rattle.errors import ANSWERS, InputError, ModelError, suggest
from rattle.loading import examples, load
from rattle.mechanism import Mechanism
from rattle.sketch.drawn import drawn
from rattle.studio import edits
from rattle.studio.bench import Bench, Outcome
from rattle.studio.completion import entries
from rattle.studio.draft import EMPTY, Draft
from rattle.studio.easel import Act, Easel
from rattle.studio.facts import facts, problem_without_place, problems_of
from rattle.studio.folder import Folder
from rattle.studio.measured import measured_columns
from rattle.studio.shelf import Source
from rattle.studio.tabs import TABS

Message = dict[str, Any]
_thumbnails: dict[str, str] = {}  # drawings of examples, for all sessions
SETTINGS = ("gravity.0", "gravity.1", "simulate.t_end", "simulate.rtol", "simulate.step")
QUICK = 1.5  # a tab that took less is computed again as soon as the model changes while it is looked at [s]


class Errand(NamedTuple):
    """Something that may take time: it is run aside, with the text as it then is, and its answer heeded here."""

    about: str  # what the page asked for
    run: Callable[[str], Any]  # of the text
    then: Callable[[Any], None]
    of_text: bool  # its answer holds for the text that it was given alone: it is run again if that was changed


class Desk:
    """What the page of one session shows and asks.

    send: gives a message to the page.  later: has a function run aside, then calls the other with what it returned.
    """

    def __init__(
        self,
        folder: Folder,
        send: Callable[[Message], None],
        later: Callable[[Callable[[], Any], Callable[[Any], None]], None],
        post: Callable[[Callable[[], None]], None],
    ) -> None:
        self.folder, self.send, self._later = folder, send, later
        self.bench = Bench(self._outcome, post)
        self.draft = Draft(folder)
        self.easel = Easel(folder)
        self.drawing = False  # whether the page draws
        self.version = 0  # of the text
        self.opened = 0  # how many models the page was given before this one
        self._heard = 0  # number of the last text that the page has sent
        self.sound: Source | None = None  # the last text without problems
        self._checking = False
        self._errands: dict[str, Errand] = {}  # those that wait, by what they are about: of several the last counts
        self._running = False
        self.shown = "motion"
        self._shape = ""  # of the model that the page computes by itself
        self.options: dict[str, Message] = {}
        self.computed: dict[str, tuple[Source, Message]] = {}  # what tabs show was computed for
        self._began: dict[str, float] = {}
        self._took: dict[str, float] = {}

    # ------------------------------------------------------------ what the page asks
    def hear(self, message: Any) -> None:
        """Do what a message of the page asks; a message that makes no sense is answered with words."""
        asked = message.get("do") if isinstance(message, dict) else None
        action = getattr(self, f"do_{asked.replace('-', '_')}", None) if isinstance(asked, str) else None
        if action is None:
            self.send({"kind": "trouble", "words": "the page asked for something that this studio does not know"})
            return
        try:
            action(**{key: value for key, value in message.items() if key != "do"})
        except Exception as error:  # whatever a message holds, the page is answered and the session goes on
            self._trouble(words_of(error), asked)

    def _trouble(self, words: str, about: Any) -> None:
        self.send({"kind": "trouble", "words": words, "about": about})

    def do_hello(self) -> None:
        """The page is there: show it everything."""
        self._send_text()
        self._check()

    def do_alive(self) -> None:
        """The page asks whether the studio is still there."""
        self.send({"kind": "alive"})

    def do_text(self, text: str, number: int = 0, opened: int | None = None) -> None:
        """The text was changed in the editor, or went back; number: which text of the page this is.

        opened: how many models the page had been given: what it says of one before this is too late.
        """
        self._heard = number or self._heard
        if text == self.draft.text or opened not in (None, self.opened):
            self._show_drawing()
            return
        self.draft.text = edits.require_size(text)
        self.version += 1
        self._send_name()
        self._check()
        self._show_drawing()

    def do_knob(self, name: str, value: Any) -> None:
        """A knob was turned, or a value entered: a number in SI units or a text such as "5 mm"."""
        if not isinstance(value, int | float | str | bool):
            raise InputError("expected a number or a text")
        typed = isinstance(value, str)  # a slider stays between its limits
        self._change(f"knob {name}", lambda text: edits.changed(text, str(name), value), typed)

    def do_contact(self, joint: str, model: str) -> None:
        """Another contact model was chosen for a joint."""
        self._change(f"contact {joint}", lambda text: edits.with_contact(text, str(joint), str(model)))

    def do_setting(self, name: str, value: str) -> None:
        """A component of gravity, or an entry of [simulate], was written."""
        if name not in SETTINGS:
            raise InputError(f"there is no setting {name!r}{suggest(str(name), SETTINGS)}")
        self._change(f"setting {name}", lambda text: edits.changed(text, name, edits.number_or_text(value)))

    def do_method(self, method: str) -> None:
        """A method of integration was chosen, "" for that which the program chooses."""
        self._change("method", lambda text: edits.with_method(text, str(method)))

    def do_show(self, tab: str, options: Message | None = None) -> None:
        """A tab was opened: what it shows is computed with these options if that has not been done."""
        self.shown = tab
        if tab in TABS and tab not in (self.bench.busy, *self.bench.waiting):
            if options is not None:
                self.options[tab] = dict(options)  # what its fields say is what it shows
            if not self._is_current(tab):
                self._compute(tab)

    def do_compute(self, tab: str, options: Message) -> None:
        """A tab is to be computed with these options."""
        if tab not in TABS:
            raise InputError(f"there is no tab {tab!r}{suggest(str(tab), TABS)}")
        self.options[tab] = dict(options)
        self._compute(tab)

    # ------------------------------------------------------------ drawing
    def do_edit(self, on: bool) -> None:
        """The page begins to draw, or ends it."""
        self.drawing = bool(on)
        self._show_drawing()

    def _show_drawing(self) -> None:
        if self.drawing:
            self._errand("sketch", self._drawn, self._send_drawing, of_text=True)

    def _drawn(self, text: str) -> Message:
        return self.easel.shown(text, self.draft.source()["file"])

    def _send_drawing(self, message: Message) -> None:
        """Tell the page a drawing, and up to which of its texts that counts."""
        self.send({**message, "heard": self._heard})

    def do_act(self, opened: int | None = None, **message: Any) -> None:
        """The hand has done something with a tool; opened: how many models the page had been given then."""
        if opened not in (None, self.opened):
            return

        def acted(text: str) -> Act:
            told = {**message, "model": self.draft.name}
            return self.easel.acted(edits.require_turnable(text), self.draft.source()["file"], told)

        self._errand(f"act {message.get('number')}", acted, lambda act: self._acted(act, message), of_text=True)

    def _acted(self, act: Act, message: Message) -> None:
        if act.text != self.draft.text:
            self.draft.text = act.text
            self.version += 1
            self._send_text(act=int(message.get("number") or 0))
            self._check()
        self._send_drawing(act.message)

    def do_grab(self, body: str, at: Sequence[float], places: Message | None = None, force: bool = False) -> None:
        """The hand takes a body, to turn the mechanism, or to pull with a force at what its motors hold."""
        x, y = map(float, at)

        def grabbed(text: str) -> None:
            self.easel.grab(text, self.draft.source()["file"], str(body), (x, y), places, bool(force))

        self._errand("grab", grabbed, lambda _: None)

    def do_pull(self, at: Sequence[float]) -> None:
        """The hand has moved."""
        x, y = map(float, at)
        self._errand("pull", lambda _: self.easel.pulled((x, y)), self.send)

    def do_measure(self, spots: Sequence[Any], snap: float = 0.0) -> None:
        """Points were clicked with the measuring tool."""

        def measured(text: str) -> Message:
            return self.easel.measured(text, self.draft.source()["file"], spots[:3], float(snap))

        self._errand("measure", measured, self.send)

    def do_let_go(self) -> None:
        """The mechanism goes back to where the text has it."""
        self._errand("pull", lambda _: self.easel.let_go(), lambda _: None)

    def do_picture_file(self, name: str) -> None:
        """The page shows a picture below the drawing, which lies beside the model."""
        model = self.draft.name
        self._errand(
            "picture",
            lambda _: {"kind": "picture-file", "name": name, "data": self.folder.picture(name, model)},
            self.send,
        )

    def do_measured(self, file: str, text: str, curves: dict[str, str], shown: list[str]) -> None:
        """A file of measured numbers was dropped on the page; nothing of it goes into the model."""
        if not isinstance(file, str) or not isinstance(text, str):
            raise InputError("expected a file of text")
        units = {str(name): str(unit) for name, unit in dict(curves).items()}
        chosen = [str(name) for name in shown]
        self._errand(f"measured {file}", lambda _: measured_columns(file, text, units, chosen), self.send)

    def do_pick(self, number: int) -> None:
        """A bar of the ensemble was clicked: its mechanism is to be seen."""
        if self.sound is not None:
            self.bench.ask("sample", source=self.sound, number=int(number))

    def do_stop(self, tab: str) -> None:
        """The user stops what is computed for a tab."""
        self.bench.stop(str(tab))

    # ------------------------------------------------------------ files
    def do_files(self, gallery: bool = False) -> None:
        """List the model files of the folder, or the shipped examples."""
        self._errand("files", lambda _: shipped() if gallery else self._listed(), self.send)

    def _listed(self) -> Message:
        files, whole = self.folder.models()
        return {"kind": "files", "files": files, "folder": self.folder.root.name, "whole": whole}

    def do_thumbnails(self, names: Sequence[str]) -> None:
        """Draw these examples, unless another session has had them drawn."""
        for name in names:
            if name in _thumbnails:
                self.send({"kind": "thumbnail", "name": name, "svg": _thumbnails[name]})
            elif name in examples():
                self.bench.ask(f"thumbnail {name}", example=name)

    def do_open(self, name: str) -> None:
        """Open a model file of the folder."""
        self._errand("open", lambda _: self.folder.read(name), lambda text: self._begin(text, name))

    def do_example(self, name: str) -> None:
        """Begin with a shipped example, without a file; tables that it reads are written out."""
        library = examples()
        if not isinstance(name, str) or name not in library:
            raise InputError(f"no example '{name}'{suggest(str(name), library)}")
        self._errand("open", lambda _: example_text(library[name]), lambda text: self._begin(text, ""))

    def do_new(self) -> None:
        """Begin with an empty sheet."""
        self._begin(EMPTY, "")

    def do_save(self, name: str = "", sure: bool = False) -> None:
        """Save under a name, or where it is; a file that this session has not written itself is asked about first."""
        if not isinstance(name, str):
            raise InputError("give a file name, such as fourbar.toml")
        if not name.strip() and not self.draft.name:
            self.do_save_as()
            return
        self._errand("save", lambda text: self._saved(text, name, bool(sure)), self._tell_saved, of_text=False)

    def _saved(self, text: str, name: str, sure: bool) -> Message:
        """Write a text; what is to be said of it, or to be asked before."""
        name = self.draft.target(name, text)
        if not sure and (question := self.draft.would_lose(name, text)):
            return {"kind": "overwrite", "name": name, "words": question}
        self.draft.write(name, text)
        return {"kind": "said", "words": f"saved as {name}"}

    def _tell_saved(self, message: Message) -> None:
        self._send_name()
        self.send(message)

    def do_save_as(self) -> None:
        """Ask under which name to save."""
        self._errand("name", self.draft.suggested, lambda name: self.send({"kind": "name", "suggested": name}))

    def do_entries(self) -> None:
        """Tell what may stand where in a model text."""
        self._errand("entries", lambda _: entries(), lambda told: self.send({"kind": "entries", **told}))

    def do_python(self) -> None:
        """The model as Python code."""
        name, saved = self.draft.name, self.draft.saved if self.draft.name else None
        self._errand(
            "python",
            lambda text: edits.as_python(text, name, saved),
            lambda code: self.send({"kind": "python", "code": code}),
        )

    def end(self) -> None:
        """The page is gone: nothing is computed for it any more."""
        self.bench.end()

    # ------------------------------------------------------------ text
    def _begin(self, text: str, name: str) -> None:
        self.draft.begin(text, name)
        self._shape = ""
        self.version += 1
        self.opened += 1
        self._errands = {about: errand for about, errand in self._errands.items() if not errand.of_text}
        self.computed.clear()
        self.options.clear()
        self.bench.drop(*TABS, "motion", "trust", "live", "sample")
        self._send_text(fresh=True)
        self._check()
        self._show_drawing()

    def _edit(self, text: str) -> None:
        if text == self.draft.text:
            return
        self.draft.text = text
        self.version += 1
        self._send_text()
        self._check()
        self._show_drawing()

    def _change(self, about: str, change: Callable[[str], str], sound: bool = True) -> None:
        """Change the text.

        sound: a change that would make a sound text wrong is refused; of a text that is wrong already none is.
        """

        def changed(text: str) -> str:
            after = change(edits.require_turnable(text))
            if sound and self.sound is not None and self.sound["text"] == text:
                Mechanism.from_text(after, self.draft.source()["file"])
            return after

        self._errand(about, changed, self._edit, of_text=True)

    def _send_text(self, fresh: bool = False, act: int = 0) -> None:
        self.send({"kind": "text", "text": self.draft.text, "fresh": fresh, "act": act, "heard": self._heard})
        self._send_name()

    def _send_name(self) -> None:
        self.send({"kind": "name-is", "name": self.draft.name, "changed": self.draft.changed})

    # ------------------------------------------------------------ what takes time
    def _errand(
        self, about: str, run: Callable[[str], Any], then: Callable[[Any], None], of_text: bool = False
    ) -> None:
        """Have something done aside, one thing after the other, so that no other page waits for it."""
        self._errands.pop(about, None)
        self._errands[about] = Errand(about, run, then, of_text)
        self._next_errand()

    def _next_errand(self) -> None:
        if self._running or not self._errands:
            return
        self._running = True
        errand = self._errands.pop(next(iter(self._errands)))
        text, version, opened = self.draft.text, self.version, self.opened
        self._later(lambda: attempted(errand, text), lambda answer: self._back(errand, version, opened, *answer))

    def _back(self, errand: Errand, version: int, opened: int, answer: Any, trouble: str) -> None:
        """An errand is done; version and opened: of the text that it was given."""
        self._running = False
        try:
            if errand.of_text and opened != self.opened:  # of a model that is gone
                pass
            elif errand.of_text and version != self.version:  # of a text that is gone: again, unless a newer one waits
                self._errands = {errand.about: errand, **self._errands}
            elif trouble:
                self._trouble(trouble, errand.about.partition(" ")[0])
            else:
                errand.then(answer)
        except Exception as error:  # what follows from it is refused
            self._trouble(words_of(error), errand.about.partition(" ")[0])
        finally:
            self._next_errand()

    # ------------------------------------------------------------ checking
    def _check(self) -> None:
        """Read the text aside; one check at a time, of the newest text."""
        if self._checking:
            return
        version, source = self.version, self.draft.source()
        self._checking = True
        self._later(lambda: check(source), lambda answer: self._checked(version, source, answer))

    def _checked(self, version: int, source: Source, answer: Message) -> None:
        self._checking = False
        if version != self.version:
            self._check()
            return
        self.send({"kind": "model", **answer})
        if answer.get("empty"):  # nothing is there that could move
            self.sound = None
            self.bench.drop(*TABS, "motion", "trust", "live", "sample")
        if answer["problems"] or answer.get("empty"):
            return
        if source != self.sound or not self._is_current("motion"):
            self.sound = source
            self._model_changed()

    def _model_changed(self) -> None:
        """Compute the motion anew; tabs say that they are out of date, the open one is computed too if it is quick."""
        self.bench.drop(*TABS, "trust", "live", "sample")
        self._compute("motion")
        for tab in self.computed:
            if tab in TABS:
                self.send({"kind": "tab", "tab": tab, "state": "old"})
        if self.shown in TABS and self._took.get(self.shown, 0.0) < QUICK:
            self._compute(self.shown)

    # ------------------------------------------------------------ computing
    def _is_current(self, tab: str) -> bool:
        return self.computed.get(tab) == (self.sound, self.options.get(tab, {}))

    def _compute(self, tab: str) -> None:
        if self.sound is None:
            self.send({"kind": "tab", "tab": tab, "state": "failed", "words": "the model has problems: see Text"})
            return
        self._began[tab] = time.monotonic()
        self.send({"kind": "tab", "tab": tab, "state": "waiting"})
        self.bench.ask(tab, source=self.sound, **self.options.get(tab, {}))

    def _outcome(self, tab: str, outcome: Outcome) -> None:
        """What the process says of a job."""
        job, _, name = tab.partition(" ")
        if job == "thumbnail":
            if outcome.kind == "done":
                _thumbnails[name] = outcome.value
                self.send({"kind": "thumbnail", "name": name, "svg": outcome.value})
            return
        if tab == "live":  # without it the page replays what is computed here
            if outcome.kind == "done":
                self._shape = outcome.value["shape"]
                self.send({"kind": "live", **outcome.value})
            return
        if tab == "sample" and outcome.kind == "done":
            self.send({"kind": "sample", **outcome.value})
            self.send({"kind": "tab", "tab": tab, "state": "done"})
            return
        if outcome.kind == "progress":
            what, share = outcome.value
            self.send({"kind": "tab", "tab": tab, "state": "running", "what": what, "share": share})
        elif outcome.kind == "done":
            self._took[tab] = time.monotonic() - self._began.get(tab, 0.0)
            if self.sound is not None:
                self.computed[tab] = (self.sound, self.options.get(tab, {}))
            self.send({"kind": "tab", "tab": tab, "state": "done", "value": outcome.value})
            if tab == "motion" and self.sound is not None:
                self.bench.ask("live", source=self.sound, known=self._shape)
                self.bench.ask("trust", source=self.sound)
        else:
            words = outcome.value if outcome.kind == "failed" else "stopped"
            self.send({"kind": "tab", "tab": tab, "state": outcome.kind, "words": words})


@cache
def title_of(path: Path) -> str:
    """What a shipped example is."""
    return str(model_file.parse(path.read_text(encoding="utf-8")).get("name", ""))


def example_text(path: Path) -> str:
    """The text of a shipped example; tables that it reads from files are written out."""
    text = path.read_text(encoding="utf-8")
    reads = any("file" in table for table in model_file.parse(text).get("tables", {}).values())
    return load(path).to_toml() if reads else text


def check(source: Source) -> Message:
    """What the page shows of a text: its facts, or its problems."""
    try:
        if not model_file.parse(source["text"]).get("bodies"):
            return empty(source)
        m = Mechanism.from_text(source["text"], source["file"])
        return {"problems": [], "facts": facts(m, model_file.parse(source["text"]))}
    except ModelError as error:
        return {"problems": problems_of(error, source["text"])}
    except Exception as error:  # a text for which reading itself fails must not end the checking of those after it
        return {"problems": [problem_without_place(words_of(error))]}


def empty(source: Source) -> Message:
    """What the page shows of a text without bodies: an empty sheet.  Raises ModelError."""
    sketch = drawn(source["text"], source["file"])
    title, settings = str(sketch.document.get("name", "")), facts(sketch.mechanism, sketch.document)["settings"]
    return {"problems": [], "empty": True, "facts": {"title": title, "settings": settings}}


def shipped() -> Message:
    """The examples, for the gallery."""
    named = [{"name": name, "title": title_of(path)} for name, path in examples().items()]
    return {"kind": "files", "gallery": True, "examples": named}


def attempted(errand: Errand, text: str) -> tuple[Any, str]:
    """The answer of an errand, and why it failed, "" if it did not."""
    try:
        return errand.run(text), ""
    except Exception as error:  # told to the page, by the thread that may
        return None, words_of(error)


def words_of(error: Exception) -> str:
    """What the page is told of an error: what is wrong, or that rattle itself is."""
    if isinstance(error, ANSWERS):
        return str(error)
    place = "".join(traceback.format_exception(error)[-3:])
    return f"rattle itself failed here; please report this:\n{place}"
