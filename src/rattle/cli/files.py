"""Commands about model files and saved results: example, check, export, kinds, schema."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from rattle.cli.command import Command
from rattle.cli.options import read_result, settings_option
from rattle.cli.output import check_files, say_written


@click.command(cls=Command)
@click.argument("name", required=False)
@click.option("-o", "--output", metavar="FILE", help="Model file to write; tables that it reads come beside it.")
def example(name: str | None, output: str | None) -> None:
    """List the shipped examples, or print one as a model file.

    Where the model reads tables from files, what is printed has their numbers in it.

    \b
    Examples:  rattle example fourbar > fourbar.toml
               rattle example piston_engine -o engine.toml
    """
    from rattle.description.file import parse
    from rattle.loading import examples, load

    shipped = examples()
    if name is None and output is not None:
        raise click.UsageError("-o needs the name of an example; `rattle example` lists them")
    if name is None:
        width = max(len(key) for key in shipped)
        for key, path in shipped.items():
            title = parse(path.read_text(encoding="utf-8")).get("name", "")
            click.echo(f"{key:{width}}  {title}")
        return
    if name not in shipped:
        from rattle.errors import suggest

        raise click.UsageError(f"no example '{name}'{suggest(name, shipped)}")
    text = shipped[name].read_text(encoding="utf-8")
    tables = [table["file"] for table in parse(text).get("tables", {}).values() if "file" in table]
    if output is None:
        click.echo(load(shipped[name]).to_toml() if tables else text, nl=False)
    else:
        _write_example(shipped[name], output, tables)


def _write_example(path: Path, output: str, tables: list[str]) -> None:
    """A shipped model file, and beside it the files of its tables."""
    from rattle.description.file import save

    targets = {path: Path(output), **{path.parent / file: Path(output).parent / file for file in tables}}
    check_files(str(path), *targets.values())
    for source, target in targets.items():
        save(target, source.read_text(encoding="utf-8"))
        say_written(target)


@click.command(cls=Command)
@click.argument("result")
@click.argument("names", nargs=-1)
@settings_option
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    required=True,
    help="File to write: .csv, .xlsx or .mat with names and units, .nc or .npz.",
)
def export(result: str, names: tuple[str, ...], settings: tuple[str, ...], output: str) -> None:
    """Write a saved result as CSV, Excel workbook or MATLAB file with units, or as .nc or .npz.

    NAMES are the curves of a .csv, .xlsx or .mat file; without them it has all.

    \b
    Examples: rattle export out.nc -o out.csv
              rattle export out.nc O3.normal rocker.angle -o two.csv
              rattle export out.nc -o out.xlsx
              rattle export out.nc -o out.mat
    """
    from rattle.exchange.curve_files import require_curve_file, write_curves
    from rattle.results import archive

    check_files(result, output)
    table = Path(output).suffix.lower() not in archive.SUFFIXES
    (require_curve_file if table else archive.require)(output)
    if names and not table:
        raise click.UsageError(f"NAMES are the columns of a .csv, .xlsx or .mat file; {output} keeps every curve")
    loaded = read_result(result, settings)
    if table:
        write_curves(loaded, output, names=names or None)
    else:
        loaded.save(output)
    say_written(output)


@click.command(cls=Command)
@click.argument("name", required=False)
def kinds(name: str | None) -> None:
    """Every joint, driver, contact and load with its fields, units and source; tables, units, functions, materials.

    Without NAME lists all; NAME is one of those listed: a kind, a family of kinds or a topic.

    \b
    Examples: rattle kinds spring
              rattle kinds units
    """
    shown = [*_families(name), *_topics(name)]
    if not shown:
        shown = [_material(name)]
    for text in shown:
        click.echo(text)


def _families(name: str | None) -> Iterator[str]:
    """Lines of all kinds, of a family of kinds or of the kinds of a name."""
    from rattle import registry
    from rattle.description.reference import common

    for family in registry.families():
        entries = {key: kind for key, kind in registry.kinds(family).items() if name in (None, key, family)}
        if entries:
            yield click.style(family, bold=True)
        for key, kind in entries.items():
            yield f"  {click.style(key, fg='cyan')}: {kind.summary}"
            yield from (f"      {line}" for line in common(family, key))
            for field, spec in kind.fields.items():
                yield f"      {field} {_unit(spec)}: {spec.meaning}{_default(spec, family)}"
            if name is not None and kind.source:
                yield f"      source: {kind.source}"


def _topics(name: str | None) -> Iterator[str]:
    """Lines of all topics, in short, or of one of them, whole."""
    from rattle.description.reference import topics

    for topic in topics().values():
        if name is None or name in (topic.name, topic.name.removesuffix("s")):
            yield f"{click.style(topic.name, bold=True)}: {topic.summary}"
            if name is not None:
                yield from (f"      {line}" for line in topic.lines)


def _material(name: str | None) -> str:
    """The line of a material.  Raises click.UsageError for another name."""
    from rattle import registry
    from rattle.description.reference import topics
    from rattle.errors import suggest
    from rattle.language.materials import MATERIALS

    if name in MATERIALS:
        return next(line for line in topics()["materials"].lines if line.startswith(f"{name}:"))
    names = [key for family in registry.families() for key in (family, *registry.kinds(family))]
    raise click.UsageError(f"no kind '{name}'{suggest(str(name), [*names, *topics(), *MATERIALS])}")


def _unit(spec: Any) -> str:
    if spec.shape == "choice":
        return " | ".join((*spec.choices, *(("true", "false") if spec.flags else ())))
    if spec.shape == "flag":
        return "true | false"
    if spec.shape == "labels":
        return "[name, ...]"
    several = {"pair": [spec.unit] * 2, "triple": [spec.unit, spec.unit, spec.turning]}.get(spec.shape)
    if several is not None:
        return f"[{', '.join(several)}]"
    return f"[{spec.unit or '-'}]" if spec.shape == "number" else f"({spec.shape})"


def _default(spec: Any, family: str) -> str:
    from rattle.registry import REQUIRED

    more = f", may use {spec.may_use}" if spec.live and family != "driver" else ""
    if spec.default is REQUIRED or callable(spec.default):
        return more
    if spec.default in (math.inf, -math.inf):
        return f" (default: no limit){more}"
    if spec.shape == "flag":
        return f" (default {str(spec.default).lower()}){more}"
    if spec.shape == "triple":
        return f" (default {', '.join(f'{number:g}' for number in spec.default)}){more}"
    return (
        f" (default {spec.default:g}){more}" if isinstance(spec.default, float) else f" (default {spec.default}){more}"
    )


@click.command(cls=Command)
def schema() -> None:
    """JSON Schema of model files, for editors that complete and check TOML.

    \b
    Example:  rattle schema > mechanism.schema.json
    """
    import json

    from rattle.description.schema import schema as make

    click.echo(json.dumps(make(), indent=2))
