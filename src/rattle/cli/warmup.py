"""The command `rattle warmup`."""

from __future__ import annotations

import click

from rattle.cli.command import Command


@click.command(cls=Command)
@click.pass_context
def warmup(ctx: click.Context) -> None:
    """Compile all kernels now, so that the first run is quick.

    \b
    Example:  rattle warmup
    """
    import time
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    from rattle.jit import folder, functions, mode

    start = time.perf_counter()
    if not functions.start():
        click.echo(f"{mode.described()}; there is nothing to compile")
        return
    if not folder.code_folder().lasting:
        ctx.exit(1)  # the warning has said why
    with ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool:
        list(pool.map(_warm, (*SHORT_WORK, *_native_modules())))
    click.echo(mode.described())
    click.echo(f"kernels are ready in {folder.cache_folder()} ({time.perf_counter() - start:.1f} s)")


WORKERS = 2  # more would each translate the small functions that many share
SHORT_WORK = ("impacts", "statics", "motion")


def _native_modules() -> list[str]:
    """Modules with functions of fixed types; those with the most functions first."""
    from collections import Counter

    from rattle.jit import functions

    count = Counter(function.__module__ for function in functions.natives())
    return sorted(count, key=lambda module: -count[module])


def _warm(what: str) -> None:
    """Compile the functions of one module that have fixed types, or, by a short analysis, those of open types."""
    import numpy as np

    from rattle.jit import functions
    from rattle.language import bytecode
    from rattle.loading import example
    from rattle.registry import kinds
    from rattle.solvers.stepper import SET_VALUED

    functions.start()
    if what == "motion":
        example("fourbar").ideal().kinematics(np.linspace(0.0, 0.1, 2000))
        example("toggle").simulate(1e-4)  # its expressions switch
        example("slider_crank_play").lyapunov(1e-2)
        bytecode.quotient(1.0, 2.0), bytecode.power(2.0, 0.5)  # by which numbers in quotes are computed
    elif what == "impacts":
        impact = example("bouncing_pin")
        for stepper in kinds("stepper").values():
            if SET_VALUED in stepper.leaf.works_with:
                impact.simulate(1e-3, method=stepper.name, step=None if stepper.leaf.adaptive else 1e-4)
        example("woodpecker").simulate(1e-4)  # velocities are driven
    elif what == "statics":
        example("fourbar").modes()
        example("balanced_arm").modes()  # several degrees of freedom
    else:
        for function in functions.natives():
            if function.__module__ == what:
                _ = function.address
