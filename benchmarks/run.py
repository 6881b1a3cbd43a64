"""Speed of rattle as ratios to yardsticks measured in the same run.

    python benchmarks/run.py [fourbar exudyn contact chain kinematics pressing startup assembly lanes oil wear pages]
                             [--repeats 7]

A ratio is rattle's time divided by the yardstick's; the aim is a time, a ratio or both.
"""

from __future__ import annotations

import argparse

import assembly
import contact
import kinematics
import lubrication
import measure
import pages
import pressing
import rhs
import startup
import straight_line
import versus_exudyn
import wear

SECTIONS = {
    "fourbar": rhs.fourbar_rows,
    "planetary": rhs.planetary_rows,
    "exudyn": versus_exudyn.rows,
    "contact": contact.rows,
    "chain": rhs.chain_rows,
    "kinematics": kinematics.kinematics_rows,
    "pressing": pressing.rows,
    "startup": startup.rows,
    "assembly": assembly.rows,
    "lanes": straight_line.rows,
    "oil": lubrication.rows,
    "wear": wear.rows,
    "pages": pages.rows,
}


def main() -> None:
    """Measure the sections asked for and print one table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("section", nargs="*", help=f"any of {', '.join(SECTIONS)}; default all")
    parser.add_argument("--repeats", type=int, default=7, help="repetitions of which the median is taken")
    asked = parser.parse_args()
    unknown = [name for name in asked.section if name not in SECTIONS]
    if unknown:
        parser.error(f"no section {unknown[0]!r}; wanted any of {', '.join(SECTIONS)}")
    rows = [row for name in asked.section or SECTIONS for row in SECTIONS[name](asked.repeats)]
    measure.show(rows)


if __name__ == "__main__":
    main()
