"""The scoreboard: times at equal error, references against closed forms, and a page that needs no other program."""

import importlib
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parent.parent
pytestmark = pytest.mark.nojit


@pytest.fixture
def board(monkeypatch):
    """A module of the benchmarks by name."""
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    return lambda name: importlib.import_module(f"scoreboard.{name}")


def test_the_time_at_an_error_is_on_the_line_of_the_best_settings(board):
    curves = board("curves")
    points = [curves.Point("p", str(n), n**-4.0, 1e-3 * n) for n in (1, 2, 4, 8, 16)]  # error = (1 ms / time)^4
    points.append(curves.Point("p", "worse", 0.5, 1.0))
    for error in (0.3, 1e-2, 1e-4):
        assert curves.seconds_at(points, error) == pytest.approx(1e-3 * error**-0.25, rel=1e-12)
    assert curves.seconds_at(points, 1e-9) is None
    assert curves.seconds_at(points, 10.0) == 1e-3
    assert len(curves.front(points)) == 5


def test_the_independent_integration_meets_the_closed_forms(board):
    bodies = board("bodies")
    pendulum = bodies.Bodies(
        (bodies.bar(1.0, 1.0, (0.0, 0.0), -math.pi / 2 + 1e-4),), (bodies.Pin(-1, (0.0, 0.0), 0, (-0.5, 0.0)),)
    )
    turn = 1e-4 * math.cos(math.sqrt(1.5 * bodies.G) * 0.7)  # small swings of a bar
    assert bodies.positions_at(pendulum, 0.7) == pytest.approx([math.sin(turn) / 2, -math.cos(turn) / 2], abs=1e-11)
    assert bodies.positions_at(bodies.windows(1), 0.3) == pytest.approx(bodies.windows_at(1, 0.3), abs=1e-9)


@pytest.mark.parametrize("make", ["double_pendulum", "four_bar", "slider_crank"])
def test_the_models_start_on_their_pins(board, make):
    bodies = board("bodies")
    model = getattr(bodies, make)()
    q = np.ravel([(one.x, one.y, one.angle) for one in model.bodies])
    v = np.ravel([(one.vx, one.vy, one.omega) for one in model.bodies])
    for pin in model.pins:
        ends = []
        for body, arm in ((pin.a, pin.at_a), (pin.b, pin.at_b)):
            at = np.array(arm)
            if body != bodies.GROUND:
                at = q[3 * body : 3 * body + 2] + bodies.turned(q[3 * body + 2], arm)
            ends.append(at)
        assert ends[0] == pytest.approx(ends[1], abs=1e-12)
    assert bodies._rows(model, q, v)[0] @ v == pytest.approx(0.0, abs=1e-12)


def test_the_page_is_made_of_what_is_written(board, monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(ROOT / "docs")
    from making import scoreboard

    curves, store = board("curves"), board("store")
    case = curves.Case("two", "Two bars", "About.", "m", np.zeros(1), [])
    points = [
        *(curves.Point("rattle", f"rtol {n}", 10.0 ** (-4 * n), 1e-3) for n in range(4)),
        *(curves.Point("Other", f"{n} steps", 10.0**-n, 1e-4 * 10**n) for n in range(4)),
    ]
    store.write(tmp_path / "board.toml", [(case, points)])
    kept = tomllib.loads((tmp_path / "board.toml").read_text(encoding="utf-8"))["cases"][0]["equal"]
    assert kept[0] == pytest.approx({"error": 1e-2, "rattle": 1e-3, "Other": 1e-2}, rel=1e-3)
    monkeypatch.setattr(scoreboard, "RESULTS", tmp_path / "board.toml")
    text = scoreboard.pages(tmp_path)["scoreboard"]
    assert "| [Two bars](#two-bars) | 10 at 10⁻² m |" in text
    assert "| 10⁻⁴ m | 1 ms | not reached |" in text
    assert (tmp_path / "pictures" / "scoreboard-two.png").exists()


def test_the_results_that_are_shown_name_every_program_and_no_folder():
    text = (ROOT / "docs" / "making" / "scoreboard.toml").read_text(encoding="utf-8")
    results = tomllib.loads(text)
    assert {"rattle", "exudyn", "mujoco"} <= set(results["versions"])
    assert "/" not in results["processor"]
    for case in results["cases"]:
        assert {"rattle"} < {point["program"] for point in case["points"]}, case["key"]
