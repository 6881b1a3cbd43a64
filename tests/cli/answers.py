"""What commands print, word for word: the lines that are kept in tests/data/answers, and how they are compared.

    python tests/cli/answers.py     # writes them anew; look at the difference before it is committed

Words are compared letter by letter, numbers up to what two machines may make of the same calculation.
"""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import sys
import tempfile
from pathlib import Path

import click
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import COMMANDS, main

KEPT = Path(__file__).parents[1] / "data" / "answers"
EXAMPLES = rt.examples()["fourbar"].parent
WIDTH = 100  # of a help text [characters]
CLOSE = 1e-3  # share by which a printed number may differ: printed with three to five digits, the last may turn
ROUNDING = 2e-9  # below it a number is nothing but rounding, and is not compared
NUMBER = re.compile(r"(?<![A-Za-z_])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
# lines that differ from run to run, between machines or versions of click
OF_THE_MACHINE = re.compile(
    r"""^( *"(wall_time|message|how|steps|rejected|runs|evaluations|rhs)"|Try 'rattle|sequential quadratic).*\n""",
    re.MULTILINE,
)
ROD = '--vary "rod_length=0.1 mm"'
QUICK = "--analysis kinematics --threads 1"
# what two runs of a chaotic motion do not share is not asked
LINES = {
    "check": ["check fourbar", "check planetary", "check cam_lift_off", "check fourbar --set l2=0.01"],
    "run": [
        "run slider_crank --t-end 50ms",
        "run slider_crank --t-end 50ms --json",
        "run bouncing_pin --t-end 0.5 --why",
        "run slider_crank_oil --t-end 5ms",
        'run slider_crank --t-end 20ms --require "max(abs(motor.torque)) < 1 N*m"',
        "run slider_crank --t-end -1",
        "run slider_crank --units mm,deg --t-end 10ms",
    ],
    "compare": ["compare fourbar --joint O9", "compare slider_crank"],
    "poincare": ["poincare slider_crank_play --of B.ex", "poincare slider_crank"],
    "kinematics": [
        "kinematics slider_crank --points 61",
        "kinematics slider_crank --points 61 --json",
        "kinematics fourbar",
    ],
    "inverse-dynamics": [
        "inverse-dynamics slider_crank --points 61",
        "inverse-dynamics slider_crank --points 61 --json",
        "inverse-dynamics slider_crank --effort-at guide --points 61",
    ],
    "equilibrium": [
        "equilibrium balanced_arm",
        "equilibrium balanced_arm --json",
        "equilibrium toggle_clamp --path --points 31",
        "equilibrium toggle_clamp --path --points 31 --json",
        "equilibrium door_hinge --holds gravity",
        "equilibrium balanced_arm --points 5",
    ],
    "modes": ["modes balanced_arm", "modes balanced_arm --json", "modes balanced_arm --mode 9"],
    "accuracy": [
        "accuracy fourbar --of rocker.angle --points 7",
        "accuracy fourbar --of rocker.angle --points 7 --json",
        "accuracy slider_crank --of slider.x",
    ],
    "sensitivity": [
        "sensitivity slider_crank --of slider.x --points 21",
        "sensitivity slider_crank --of slider.x --points 21 --json",
        "sensitivity fourbar --of nothing.x",
    ],
    "ensemble": [
        f'ensemble slider_crank -n 16 {ROD} --of "max(slider.ax)" {QUICK}',
        f'ensemble slider_crank -n 16 {ROD} --of "max(slider.ax)" {QUICK} --json',
        "ensemble slider_crank",
    ],
    "sweep": [
        'sweep slider_crank --analysis kinematics --over "rod_length=.1:.2:5" --of "max(slider.ax)" --threads 1',
        'sweep slider_crank --analysis kinematics --over "rod_length=.1:.2:5" --of "max(slider.ax)" --threads 1 --json',
        'sweep slider_crank --over rod_length --of "max(slider.ax)"',
    ],
    "tolerance": [
        f'tolerance slider_crank {ROD} --of "at(slider.x, 5 ms)" -n 64 {QUICK}',
        f'tolerance slider_crank {ROD} --of "at(slider.x, 5 ms)" -n 64 {QUICK} --json',
        'tolerance slider_crank --of "max(slider.ax)" --cost rod_length=2',
    ],
    "optimise": [
        'optimise path_generator --ideal --analysis kinematics --vary a=.03:.05 --minimise "sd(coupler.P.y)"',
        'optimise path_generator --ideal --analysis kinematics --vary a=.03:.05 --minimise "sd(coupler.P.y)" --json',
        'optimise path_generator --minimise "sd(coupler.P.y)" --vary a',
    ],
    "power": [
        "power slider_crank",
        "power slider_crank --at 1ms",
        "power slider_crank --json",
        "power fourbar --cycle -1",
    ],
    "film": [
        'film --viscosity "50 mPa*s" --length "10 mm" --radius "10 mm" --clearance "50 um"',
        'film --viscosity 0.02 --length 0.03 --radius 0.05 --clearance 1e-4 --load 1000 --speed "3000 rpm"',
        "film --viscosity 0.02 --length 0.03 --radius 0.05 --clearance 1e-4 --load 1000 --speed 50 --json",
        "film --viscosity 0.02",
    ],
    "orbit": ["orbit slider_crank_oil --t-end 5ms", "orbit slider_crank_oil --t-end 5ms --json", "orbit slider_crank"],
    "wear": [
        "wear slider_crank_worn --cycles 2 --jump 1",
        "wear slider_crank_worn --cycles 2 --jump 1 --json",
        "wear slider_crank",
    ],
    "report": ["report slider_crank -o report.txt"],
    "fit": ['fit H7/g6 "8 mm"', "fit H8/f7 6mm 10mm 0.025", 'fit H7/g6 "8 mm" --json', 'fit H7/p6 "8 mm"', "fit H7/g6"],
    "oil": [
        'oil "ISO VG 46" "40 degC" "60 degC" "-10 degC"',
        'oil "ISO VG 100" --vi 140 --density "860 kg/m^3" --json 333.15',
        'oil "ISO VG 47"',
        'oil "ISO VG 46" 60',
    ],
    "code": ["code fourbar_onesided -o here.c"],
    "plot": ["plot nothing.nc rocker.angle"],
}


def help_of(command: str) -> str:
    """The help text of a command."""
    return CliRunner().invoke(main, [command, "--help"], terminal_width=WIDTH, prog_name="rattle").output


def help_of_all() -> str:
    """The help text of the group."""
    return CliRunner().invoke(main, ["--help"], terminal_width=WIDTH, prog_name="rattle").output


def answer(line: str) -> str:
    """What a command line prints, and its exit status."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        result = CliRunner().invoke(main, ["-q", *shlex.split(line)], terminal_width=WIDTH, prog_name="rattle")
    printed = result.output.replace(f"{EXAMPLES}{os.sep}", "")
    return OF_THE_MACHINE.sub("", f"$ rattle {line}\n{printed}exit status {result.exit_code}\n")


def answers(command: str) -> str:
    """What all lines of a command print."""
    return "\n".join(map(answer, LINES[command]))


def difference(printed: str, kept: str) -> str:
    """Where two texts differ by more than numbers may; "" if they do not."""
    new, old = printed.splitlines(), kept.splitlines()
    for k, (line, before) in enumerate(zip(new, old, strict=False), 1):
        if NUMBER.sub("#", line).split() != NUMBER.sub("#", before).split() or not _close(line, before):
            return f"line {k}:\n  now   {line}\n  kept  {before}"
    return "" if len(new) == len(old) else f"{len(new)} lines, kept are {len(old)}"


def _close(line: str, before: str) -> bool:
    numbers, kept = ([float(text) for text in NUMBER.findall(words)] for words in (line, before))
    return all(
        abs(a - b) <= max(CLOSE * abs(b), ROUNDING) or max(abs(a), abs(b)) < ROUNDING
        for a, b in zip(numbers, kept, strict=True)
    )


def write() -> None:
    """Write all texts anew."""
    KEPT.mkdir(parents=True, exist_ok=True)
    (KEPT / "rattle.help.txt").write_text(help_of_all(), encoding="utf-8")
    for command in COMMANDS:
        (KEPT / f"{command}.help.txt").write_text(help_of(command), encoding="utf-8")
    for command in LINES:
        (KEPT / f"{command}.answers.txt").write_text(answers(command), encoding="utf-8")


if __name__ == "__main__":
    click.echo(f"writing {KEPT}", file=sys.stderr)
    write()
