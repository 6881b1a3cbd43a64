"""Speed of rattle as ratios to yardsticks measured in the same run.

    python benchmarks/run.py [fourbar exudyn contact stack chain kinematics pressing startup assembly lanes
                              contact_lanes oil wear pages peers] [--repeats 7] [--keep docs/making/scoreboard.toml]

A ratio is rattle's time divided by the yardstick's; the aim is a time, a ratio or both.
"""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

import assembly
import contact
import contact_lanes
import kinematics
import lubrication
import measure
import pages
import peers
import pressing
import rhs
import stack
import startup
import straight_line
import versus_exudyn
import wear

SECTIONS = {
    "fourbar": rhs.fourbar_rows,
    "planetary": rhs.planetary_rows,
    "exudyn": versus_exudyn.rows,
    "contact": contact.rows,
    "stack": stack.rows,
    "chain": rhs.chain_rows,
    "kinematics": kinematics.kinematics_rows,
    "pressing": pressing.rows,
    "startup": startup.rows,
    "assembly": assembly.rows,
    "lanes": straight_line.rows,
    "contact_lanes": contact_lanes.rows,
    "oil": lubrication.rows,
    "wear": wear.rows,
    "pages": pages.rows,
    "peers": peers.rows,
}


def main() -> None:
    """Measure the sections asked for and print one table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("section", nargs="*", help=f"any of {', '.join(SECTIONS)}; default all")
    parser.add_argument("--repeats", type=int, default=7, help="repetitions of which the median is taken")
    parser.add_argument("--keep", type=Path, help="file for the results of peers, which the documentation shows")
    asked = parser.parse_args()
    unknown = [name for name in asked.section if name not in SECTIONS]
    if unknown:
        parser.error(f"no section {unknown[0]!r}; wanted any of {', '.join(SECTIONS)}")
    sections = {**SECTIONS, "peers": partial(peers.rows, kept=asked.keep)}
    rows = [row for name in asked.section or sections for row in sections[name](asked.repeats)]
    measure.show(rows)


if __name__ == "__main__":
    main()
