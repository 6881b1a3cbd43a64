"""Drawings of mechanisms are those that were looked at: where their ink is, coarsely, at three instants.

`pictures.txt` beside this file has the darkness of every cell of each picture, 00 for paper to ff, written anew by
`PYTHONPATH=tests python tests/plots/test_same_pictures.py` after a look at the pictures, which that keeps in
build/pictures.
"""

from pathlib import Path

import numpy as np
import pytest

from drawn_mechanisms import EXAMPLES, HIGH, WIDE, cells, motion, pictures

DRAWN = Path(__file__).with_name("pictures.txt")
LOOKED_AT = Path(__file__).parents[2] / "build" / "pictures"
# Other versions of matplotlib and its renderer smooth edges otherwise: a hundredth of the ink.  A spring, a foot or a
# pin that is missing or elsewhere is three of them and more in each of these pictures.
UNLIKE = 0.03  # ink that differs, as a share of all


def drawn():
    """Cells (3, HIGH, WIDE) by name, as they are in the file."""
    blocks = (block.split() for block in DRAWN.read_text().split("\n\n"))
    return {name: np.array([list(bytes.fromhex(row)) for row in rows]).reshape(3, HIGH, WIDE) for name, *rows in blocks}


@pytest.mark.parametrize("name", [*EXAMPLES, "own"])
def test_a_mechanism_is_drawn_as_it_was_looked_at(name):
    for k, (figure, before) in enumerate(zip(pictures(motion(name)), drawn()[name], strict=True)):
        now = cells(figure)
        unlike = np.abs(now - before).sum() / before.sum()
        assert unlike < UNLIKE, f"picture {k} of {name} differs by {unlike:.0%}"


def write():
    """Write the file, and the pictures to look at."""
    LOOKED_AT.mkdir(parents=True, exist_ok=True)
    blocks = []
    for name in (*EXAMPLES, "own"):
        rows = []
        for k, figure in enumerate(pictures(motion(name))):
            rows += [bytes(row.tolist()).hex() for row in cells(figure)]
            figure.savefig(LOOKED_AT / f"{name}_{k}.png", dpi=100)
        blocks.append("\n".join([name, *rows]))
    DRAWN.write_text("\n\n".join(blocks) + "\n")


if __name__ == "__main__":
    write()
