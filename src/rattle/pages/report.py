"""A report of a mechanism for people who do not use this program: one page that prints well, or a PDF."""

from __future__ import annotations

import datetime
import itertools
import logging
import math
import os
import platform
from collections.abc import Iterable, Sequence
from functools import partial
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from rattle.atomic_file import atomic
from rattle.errors import InputError
from rattle.exchange.measured import require_readable, sources_of
from rattle.exchange.residuals import Source
from rattle.pages import report_measured, report_model, report_summary
from rattle.pages.print_pdf import print_pdf, require_browser
from rattle.pages.report_figures import drawing
from rattle.pages.report_html import Section, listed, paragraph, sentence, table
from rattle.pages.report_study import FORCES, MOTION, Study, answer_section, in_blocks, section_parts, study
from rattle.version import __version__

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

SUFFIXES = (".html", ".pdf")
PAPERS = ("A4", "Letter")
# sections of small pictures, tables and lists
LEFT_OUT, MADE = "Not in this report", "How this report was made"
SMALL = (MOTION, FORCES, LEFT_OUT, MADE)
FIRST_OF_MOTION, OF_ANSWERS = 20, 95  # places of the first section about the motion, and of those of answers in blocks
_log = logging.getLogger("rattle")


def report(
    m: Mechanism, path: str | os.PathLike[str], *, title: str = "", author: str = "", t_end: float | None = None,
    paper: str = "A4", progress: bool = False, measured: Source | Iterable[Source] = (),
) -> Path:  # fmt: skip
    """Write a report of a mechanism; see `Mechanism.report`."""
    sources = sources_of(measured)
    write_report(m, path, title=title, author=author, t_end=t_end, paper=paper, progress=progress, measured=sources)
    return Path(path)


def write_report(
    m: Mechanism, path: str | os.PathLike[str], *, title: str = "", author: str = "", t_end: float | None = None,
    paper: str = "A4", command: str = "", progress: bool = False, measured: Sequence[Source] = (),
) -> Study:  # fmt: skip
    """As `report`; returns what was found out.  command: what was typed to make it; "" says how to make it again."""
    target = Path(path)
    require_name(target, paper)
    require_readable(measured)
    findings = study(m, t_end, progress, measured)
    _log.info("report: drawing and writing")
    page = page_of(findings, title, author, command)
    if target.suffix.lower() == ".pdf":
        print_pdf(page, target, paper)
    else:
        with atomic(target) as file:
            file.write_text(page, encoding="utf-8")
    return findings


def require_name(path: Path, paper: str = "A4") -> None:
    """Refuse what cannot be written before anything runs.  Raises InputError, MissingProgram for a PDF."""
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: a report needs a name ending in {' or '.join(SUFFIXES)}")
    if paper not in PAPERS:
        raise InputError(f"paper {paper!r}: expected {' or '.join(PAPERS)}")
    if path.suffix.lower() == ".pdf":
        require_browser(path)


# ---------------------------------------------------------------- the page
def page_of(s: Study, title: str = "", author: str = "", command: str = "") -> str:
    """The whole report as one HTML page that needs nothing else."""
    name = title or s.m.name or "Mechanism"
    day = datetime.date.today().isoformat()
    style = files("rattle.pages").joinpath("report.css").read_text(encoding="utf-8")
    style += _print_lines(name, f"rattle {__version__}, {day}")
    sections = _sections(s)
    present = [part for part in sections if part.body]
    why = [f"{part.title}: {sentence(part.reason)}" for part in sections if not part.body and part.reason]
    extra = {"without play": "Motion without play", "quasi-static": "Slow motion", "modes": "Natural frequencies"}
    why += [f"{words}: {sentence(s.reasons[what])}" for what, words in extra.items() if what in s.reasons]
    if why:
        present.append(Section(LEFT_OUT, listed(why)))
    present += [_making(s, command), _appendix(s)]
    body = _head(s, name, author, day) + _contents(present) + _flow(present)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{escape(name)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n{_numbered(body)}\n</main>\n"
        "</body>\n</html>\n"
    )


def _sections(s: Study) -> list[Section]:
    """The parts of the report in their order; without a motion those that stand before it."""
    before = [report_summary.trust_section(s), report_model.model_section(s), report_model.assumptions_section(s)]
    asked = [entry for part in section_parts() for entry in part.SECTIONS]
    asked += [(OF_ANSWERS, partial(answer_section, question=question)) for question in in_blocks()]
    asked.append((report_measured.PLACE, report_measured.measured_section))
    last = FIRST_OF_MOTION if s.run is None else math.inf
    in_order = sorted((entry for entry in asked if entry[0] < last), key=lambda entry: entry[0])
    return before + [make(s) for _, make in in_order]


def _head(s: Study, name: str, author: str, day: str) -> str:
    by = f"{escape(author)}, " if author else ""
    trouble = "".join(paragraph(sentence(fault)) for fault in s.trouble)
    alarm = f'<div class="alarm" role="alert"><strong>This needs attention.</strong>{trouble}</div>' if trouble else ""
    lead = ""
    if s.run is not None:
        span = f"Motion from t = 0 to {s.run.trust.t_end:.4g} s"
        lead = paragraph(f"{span}; numbers are of the whole run, including its start.", "lead")
    return (
        f'<header><p class="kind">Mechanism report</p><h1>{escape(name)}</h1>'
        f'<p class="by">{by}<time datetime="{day}">{day}</time>, made with rattle {__version__}</p></header>'
        f"{alarm}{report_summary.headline(s)}{report_summary.verdict(s)}{lead}{drawing(s)}"
    )


def _contents(sections: Sequence[Section]) -> str:
    items = "".join(f'<li><a href="#{section.anchor}">{escape(section.title)}</a></li>' for section in sections)
    return f'<nav aria-label="Contents"><ol>{items}</ol></nav>'


def _flow(sections: Sequence[Section]) -> str:
    """All sections; neighbours with small contents together, so that paper has them in two columns."""
    groups = itertools.groupby(sections, lambda section: section.title in SMALL)
    texts = ((small, "".join(map(_section, of))) for small, of in groups)
    return "".join(f'<div class="small">{text}</div>\n' if small else text for small, text in texts)


def _section(section: Section) -> str:
    return f'<section id="{section.anchor}"><h2>{escape(section.title)}</h2>{section.body}</section>\n'


def _numbered(body: str) -> str:
    """Figures and tables with captions get their numbers in the order of the page."""
    for tag, word in (("figcaption", "Figure"), ("caption", "Table")):
        first, *others = body.split(f"<{tag}>")
        body = first + "".join(f"<{tag}><b>{word} {n}.</b> {rest}" for n, rest in enumerate(others, 1))
    return body


# ---------------------------------------------------------------- how it was made
def _making(s: Study, command: str) -> Section:
    run = s.run
    language = f"Python {platform.python_version()} for {platform.system()} on {platform.machine()}"
    packages = ", ".join(f"{package} {_version(package)}" for package in ("numpy", "scipy", "llvmlite", "matplotlib"))
    rows = [("program", f"rattle {__version__}, {language}"), ("packages", packages)]
    if run is not None:
        facts, stats = run.provenance, run.stats
        words = {"rtol": "relative tolerance", "atol": "absolute tolerance", "step": "step [s]"}
        numbers = [f"{word} {facts[key]:g}" for key, word in words.items() if facts.get(key) is not None]
        rows.append(("method", ", ".join([str(facts.get("method")), *numbers])))
        count = f"{stats.get('steps')}, {stats.get('rejected')} more repeated"
        rows.append(("steps", f"{count}, in {float(stats.get('wall_time', 0.0)):.2g} s of computing"))
    again = command or 'the model text below, saved as "model.toml", with: rattle report model.toml -o report.html'
    command_of_it = f"<div class='making'><p>Made by</p><pre>{escape(again)}</pre></div>"
    return Section(MADE, table(("what", "which"), rows) + command_of_it)


def _version(package: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def _appendix(s: Study) -> Section:
    lead = paragraph("The complete model as text, with all changes: from it everything above can be computed again.")
    text = s.m.to_toml()
    top = "".join(itertools.takewhile(lambda line: line.startswith("#") or not line.strip(), text.splitlines(True)))
    rest = escape(text[len(top) :])
    return Section(
        "Appendix: model file", f'{lead}<pre class="file"><span class="top">{escape(top)}</span>{rest}</pre>'
    )


def _print_lines(name: str, maker: str) -> str:
    """What stands at the edges of printed pages."""

    def quoted(text: str) -> str:
        return '"' + "".join(c if c.isalnum() or c in " .,-" else f"\\{ord(c):x} " for c in text) + '"'

    return (
        f"@page{{@top-left{{content:{quoted(name)}}}@bottom-left{{content:{quoted(maker)}}}"
        '@bottom-right{content:counter(page) " / " counter(pages)}}\n@page:first{@top-left{content:""}}\n'
    )
