"""Curves of the studio on a phone: which colour is whose is said before them."""

import pytest

pytest.importorskip("panel")
import rattle as rt
from rattle.answers.blocks import of_result
from rattle.studio import sheets

pytestmark = [pytest.mark.nojit]


def test_the_names_of_colours_stand_above_the_curves():
    joints = "OABQ"
    run = rt.example("crank_rocker_play").simulate(2e-3)
    block = of_result("Forces", run, [f"{name}.force" for name in joints], {f"{name}.force": name for name in joints})
    plot = sheets._curves(block, sheets.LIGHT._replace(narrow=True), None).object
    (legend,) = plot.legend
    assert legend in plot.above
    assert [item.label.value for item in legend.items] == list(joints)
    assert legend.ncols >= 4  # in one line
