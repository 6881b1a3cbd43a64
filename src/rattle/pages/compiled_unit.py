"""A model with contacts and events as a Functional Mock-up Unit (FMI 3.0): co-simulation by the compiled kernels.

It holds what a page holds behind its pictures, with machine code for this platform in place of the engine.  The model
in C is that of `model_in_c`; what calls it stands in `trace/fmu_sources`.
"""

from __future__ import annotations

from rattle.analyses.straight_line.mock_up import MockUp, meaning_of
from rattle.mechanism import Mechanism
from rattle.pages.engine import kernels_of_platform
from rattle.pages.live_model import LiveModel, live_model
from rattle.pages.model_in_c import FunctionsInC, ModelInC
from rattle.solvers.stepper import RTOL
from rattle.trace import fmu
from rattle.trace.fmu_description import Experiment, Kind, Variable, description
from rattle.version import __version__

MAIN = "fmi3_run.c"  # the file to compile; it includes the others
WRITTEN = (MAIN, "fmi3.h", "instance.h", "instance.c", "run.c", "start.c", "calls.c")


def compiled_unit(m: Mechanism, name: str, stop: float) -> MockUp:
    """An FMU of a model that kernels move.

    name: a short one, of which files are named; stop: when a run probably ends [s].
    Raises TraceError for laws in Python, what else no page moves, and where there is no C compiler, with the reason.
    """
    functions = FunctionsInC()
    live = live_model(m, stop, alone=True, tape=functions, derived=True)
    kernels = kernels_of_platform()
    settings, identifier, title = m.model.settings, fmu.identifier(name), m.name or name
    experiment = Experiment(stop, settings.rtol or RTOL, settings.output)
    header = f"{title}, written by rattle {__version__}".replace("*/", "* /").replace("/*", "/ *")
    variables, text = _variables(live), f"/* {header} */\n{ModelInC(live.data, functions, kernels).text()}"
    plain = description(variables, identifier, title, "", experiment, exchange=False)
    token = fmu.token(text.encode() + plain)
    files = {"model.c": f'{text}\n#define TOKEN "{token}"\n', **fmu.written(WRITTEN)}
    entries = {
        "modelDescription.xml": description(variables, identifier, title, token, experiment, exchange=False),
        fmu.library_name(identifier): fmu.shared_library(files, MAIN, kernels.content),
    }
    notes = [f"the parameter {parameter} is fixed: {why}" for parameter, why in live.fixed.items()]
    return MockUp(fmu.archive(entries), [*live.notes, *notes])


def _variables(live: LiveModel) -> list[Variable]:
    """All variables, in the order of their value references, which `fmi3_run.c` knows."""
    variables = [Variable("t", Kind.TIME, "s", "time")]
    for name, knob in live.parameters.items():
        about = knob.description or knob.label or "parameter"
        variables.append(Variable(name, Kind.PARAMETER, knob.unit, about, knob.value, knob.minimum, knob.maximum))
    units = live.data["result"]["units"]
    return variables + [Variable(name, Kind.CURVE, units[name], meaning_of(name)) for name in live.names]
