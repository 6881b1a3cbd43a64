"""Spectra: a sine shows as its amplitude at its frequency, and multiples of the turning speed are marked."""

import numpy as np
import pytest
from click.testing import CliRunner

from circling import OMEGA, circling
from rattle.cli.main import main
from rattle.results.spectrum import amplitude_spectrum, steady_turns

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


@pytest.mark.parametrize("n", [200, 201])
def test_a_sine_shows_as_its_amplitude_at_its_frequency(n):
    t = 0.01 * np.arange(n)
    whole = 1.0 / (0.01 * n)  # one turn in all [Hz]
    f, a = amplitude_spectrum(t, 7.0 + 3.0 * np.sin(2 * np.pi * 10 * whole * t + 0.4))
    assert f == pytest.approx(whole * np.arange(1, n // 2 + 1))
    assert a[9] == pytest.approx(3.0)  # frequencies of the grid: exact but for rounding
    assert a[[8, 10]] == pytest.approx(1.5)
    np.testing.assert_allclose(np.delete(a, [8, 9, 10]), 0.0, atol=1e-13)


def test_a_sine_between_two_frequencies_loses_at_most_fifteen_per_cent():
    t = np.linspace(0.0, 1.0, 1000, endpoint=False)
    largest = [amplitude_spectrum(t, np.cos(2 * np.pi * f * t))[1].max() for f in np.linspace(40.0, 41.0, 11)]
    assert 0.845 < min(largest) < 0.855  # the window's loss between two frequencies is 1.42 dB (Harris)
    assert max(largest) == pytest.approx(1.0, abs=1e-3)


def test_spectra_are_refused_where_they_would_mislead():
    t = np.linspace(0.0, 1.0, 100)
    with pytest.raises(ValueError, match="evenly spaced"):
        amplitude_spectrum(t**2, t)
    with pytest.raises(ValueError, match="at least 8"):
        amplitude_spectrum(t[:7], t[:7])
    with pytest.raises(ValueError, match="finite"):
        amplitude_spectrum(t, np.where(t > 0.5, np.nan, t))


def test_a_shorter_last_interval_is_left_out():
    t = 0.01 * np.arange(100)
    y = np.sin(2 * np.pi * 5 * t)
    with_end = amplitude_spectrum(np.append(t, 0.993), np.append(y, 40.0))
    np.testing.assert_array_equal(with_end[1], amplitude_spectrum(t, y)[1])


def test_only_a_steady_turning_has_orders():
    t = np.linspace(0.0, 1.0, 101)
    assert steady_turns(t, np.full(101, -6.0 * np.pi)) == pytest.approx(3.0)
    assert steady_turns(t, 20.0 + np.sin(t)) == 0.0
    assert steady_turns(t, np.full(101, np.pi)) == 0.0  # half a turn


def test_the_picture_has_a_panel_per_unit_and_says_its_window():
    r = circling(2001)
    figure = r.plot_spectrum("O.fx", "O.fy", "arm.x")
    first, second = figure.axes[:2]
    assert first.get_ylabel() == "amplitude of\nforce [N]"
    assert [text.get_text() for text in first.get_legend().get_texts()] == ["O.fx", "O.fy"]
    assert second.get_xlabel() == "frequency [Hz]"
    assert any("Hann" in text.get_text() for text in second.texts)
    f, a = r.spectrum("arm.x")
    strongest = f[np.argmax(a)]
    assert abs(strongest - OMEGA / (2 * np.pi)) <= f[0]
    with pytest.raises(KeyError, match="did you mean"):
        r.plot_spectrum("O.fz")


def test_the_command_draws_spectra_and_compares_results(tmp_path):
    circling(2001).save(tmp_path / "out.npz")
    circling(501).save(tmp_path / "coarse.npz")

    def run(*words):
        return CliRunner().invoke(main, ["plot", str(tmp_path / "out.npz"), *words])

    assert run("O.fx", "--spectrum").exit_code == 0
    assert (tmp_path / "out-spectrum.png").exists()
    done = run("O.fx", "--compare", f"few={tmp_path / 'coarse.npz'}", "--robust", "-o", str(tmp_path / "two.svg"))
    assert done.exit_code == 0, done.output
    assert ">O.fx, few<" in (tmp_path / "two.svg").read_text()
    for words, saying in ((["--spectrum"], "needs curves"), (["O.fx", "--spectrum", "--over", "O.fy"], "--over")):
        done = run(*words)
        assert done.exit_code == 2
        assert saying in done.output
