"""A Functional Mock-up Unit (FMI 3.0): its C sources, the shared library made of them, and the archive of both.

The equations are functions of graphs (`rattle.trace.c`); what calls them stands in `fmu_sources` and is the same for
every model.  Source: Functional Mock-up Interface Specification, version 3.0 (Modelica Association, 2022).
"""

from __future__ import annotations

import io
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from rattle.errors import TraceError
from rattle.language.recorded import Operand
from rattle.solvers.tableau import Tableau
from rattle.trace import c
from rattle.trace.graph import Graph

MAIN = "fmi3.c"  # the file to compile; it includes the others
WRITTEN = (MAIN, "fmi3.h", "instance.h", "instance.c", "mechanism.c", "calls.c")  # the same in every FMU
# a second level of optimisation takes four times as long and finds nothing in straight-line code; workspaces hold
# whole and real numbers in the same cells, of which clang would think at the first level that they are apart
FLAGS = (
    *("-std=c99", "-O1", "-fno-strict-aliasing", "-fPIC", "-shared"),
    *("-DFMI3_OVERRIDE_FUNCTION_PREFIX", "-Werror=implicit"),
)
PATIENCE = 600.0  # of the compiler [s]
SYSTEMS = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("windows", ".dll")}
MACHINES = {
    "x86_64": "x86_64", "amd64": "x86_64", "i386": "x86", "i686": "x86", "x86": "x86", "aarch64": "aarch64",
    "arm64": "aarch64", "riscv64": "riscv64", "ppc64": "ppc64",
}  # fmt: skip


FUNCTIONS = ("derivative", "project", "outputs", "prepare", "initial_energy", "follow", "correct", "close_rates")
NEEDED = FUNCTIONS[:5]  # also without parameters


class Input(NamedTuple):
    """A parameter that can be set [SI]; varies: also during a run."""

    name: str
    value: float
    least: float
    most: float
    varies: bool


class Equations(NamedTuple):
    """A mechanism with np parameters as functions of graphs of exact operations, and the numbers they go with.

    Inputs of the first three are t, y (ny), constants (nc), of the others t, y, parameters (np), E_0.
    """

    derivative: tuple[Graph, Sequence[Operand]]  # dy/dt, flag
    project: tuple[Graph, Sequence[Operand]]  # y on the constraints, flag
    outputs: tuple[Graph, Sequence[Operand]]  # curves, flag
    prepare: tuple[Graph, Sequence[Operand]]  # the constants
    initial_energy: tuple[Graph, Sequence[Operand]]  # energy at the start [J]
    follow: tuple[Graph, Sequence[Operand]]  # parameters that follow from others, flag: the model is of the same kind
    correct: tuple[Graph, Sequence[Operand]] | None  # positions corrected, what is left open, flag
    close_rates: tuple[Graph, Sequence[Operand]] | None  # rates, by how much given ones are missed, flag
    inputs: Sequence[Input]
    start: Sequence[float]  # (ny,) y at t = 0 at the parameters' values
    positions: int  # 3 nb
    energies: Mapping[str, int]  # KINETIC, POTENTIAL, BALANCE: numbers of curves; WORK: a number in y
    numbers: Mapping[str, float]  # that `fmu_sources` asks for
    tableau: Tableau  # of the adaptive method that takes the steps of co-simulation


def equations_text(equations: Equations, header: str, token: str) -> str:
    """The file equations.c."""
    functions = [
        c.function(entry[0], entry[1], name)
        for name in (FUNCTIONS if equations.inputs else NEEDED)
        if (entry := getattr(equations, name)) is not None
    ]
    sizes = {
        "NY": len(equations.start), "NQ": equations.positions, "NO": len(equations.outputs[1]) - 1,
        "NC": len(equations.prepare[1]), "NP": len(equations.inputs), "ND": len(equations.follow[1]) - 1,
    }  # fmt: skip
    defined = {**sizes, **equations.energies, **{name: c.number(x) for name, x in equations.numbers.items()}}
    inputs = equations.inputs
    comment = header.replace("*/", "* /").replace("/*", "/ *")
    parts = [
        f"/* {comment} */\n{c.INCLUDES}",
        "\n".join(f"#define {name} {value}" for name, value in defined.items()),
        f'#define TOKEN "{token}"\n',
        _numbers("start[NY]", equations.start),
        _numbers("nominal[NP + 1]", [*(parameter.value for parameter in inputs), 0.0]),
    ]
    if inputs:
        quoted = ", ".join(f'"{parameter.name}"' for parameter in inputs)
        parts += [
            f"static const char *const names[NP] = {{{quoted}}};",
            _numbers("least[NP]", [parameter.least for parameter in inputs]),
            _numbers("most[NP]", [parameter.most for parameter in inputs]),
            f"static const int varies[NP] = {{{', '.join(str(int(x.varies)) for x in inputs)}}};",
        ]
    tableau, few = equations.tableau, equations.tableau.stages
    ends = [*tableau.ends, np.zeros(few)][:3]
    rows = ", ".join("{" + ", ".join(map(c.number, row)) + "}" for row in tableau.a[:few, :few].tolist())
    parts += [
        f"enum {{ STAGES = {few}, ORDER = {tableau.order} }};",
        f"static const double A[STAGES][STAGES] = {{{rows}}};",
        *(_numbers(f"{name}[STAGES]", row) for name, row in zip(("B", "ERROR", "DAMPING"), ends, strict=True)),
        _numbers("C[STAGES]", tableau.c[:few]),
        "", *c.helpers(functions), *functions,
    ]  # fmt: skip
    return "\n".join(parts)


def _numbers(declared: str, values: Iterable[float]) -> str:
    return f"static const double {declared} = {{{', '.join(c.number(float(x)) for x in values)}}};"


def sources(equations: Equations, header: str, token: str) -> dict[str, str]:
    """C files by name."""
    return {"equations.c": equations_text(equations, header, token), **written(WRITTEN)}


def written(names: Iterable[str]) -> dict[str, str]:
    """C files by name that are the same in every FMU."""
    folder = Path(__file__).with_name("fmu_sources")
    return {name: (folder / name).read_text(encoding="utf-8") for name in names}


def identifier(name: str) -> str:
    """What the files of an FMU are called, from a short name."""
    word = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")[:60] or "mechanism"
    return word if word[0].isalpha() else f"m_{word}"


def token(content: bytes) -> str:
    """By which the description and the library of an FMU know that they belong together, from what they are made of."""
    return f"{{{uuid.uuid5(uuid.NAMESPACE_OID, content.hex())}}}"


# ---------------------------------------------------------------- the shared library
def library_name(identifier: str) -> str:
    """Where the library of this platform stands in an FMU.  Raises TraceError where FMI has no name for it."""
    machine, system = MACHINES.get(platform.machine().lower()), SYSTEMS.get(sys.platform)
    if machine is None or system is None:
        raise TraceError(f"FMI has no name for this platform ({platform.machine()}, {sys.platform})")
    return f"binaries/{machine}-{system[0]}/{identifier}{system[1]}"


def shared_library(files: Mapping[str, str], main: str, kernels: bytes = b"") -> bytes:
    """The shared library made of C files, by the compiler named in the environment (CC), cc, gcc or clang.

    main: the file that includes the others.  kernels: an object file that it is linked with.
    Raises TraceError if there is none, or with what it says.
    """
    compilers = [os.environ.get("CC", ""), "cc", "gcc", "clang"]
    program = next((path for compiler in compilers if compiler and (path := shutil.which(compiler))), None)
    if program is None:
        raise TraceError("no C compiler was found (cc, gcc, clang, or the one named by CC)")
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        objects = []
        if kernels:
            Path(folder, "kernels.o").write_bytes(kernels)
            objects.append("kernels.o")
        try:
            done = subprocess.run(
                [program, *FLAGS, main, *objects, "-o", "library", "-lm"], cwd=folder, timeout=PATIENCE, text=True,
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, errors="replace",
            )  # fmt: skip
        except (OSError, subprocess.TimeoutExpired) as error:
            raise TraceError(f"{program} failed: {error}") from None
        if done.returncode != 0:
            raise TraceError(f"{program} failed: {done.stdout.strip()[:500] or f'exit status {done.returncode}'}")
        return Path(folder, "library").read_bytes()


# ---------------------------------------------------------------- the archive
def build_description(identifier: str) -> bytes:
    """How other tools compile the sources."""
    root = ElementTree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ElementTree.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = ElementTree.SubElement(configuration, "SourceFileSet", language="C99")
    ElementTree.SubElement(files, "SourceFile", name=MAIN)
    if sys.platform != "win32":
        ElementTree.SubElement(configuration, "Library", name="m", external="true", description="C's mathematics")
    return xml(root)


def xml(root: ElementTree.Element) -> bytes:
    """An XML file, indented."""
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def archive(files: Mapping[str, bytes]) -> bytes:
    """A zip file; the same bytes for the same files, whenever and wherever it is made."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as target:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.create_system, entry.compress_type = 3, zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            target.writestr(entry, content)
    return buffer.getvalue()
