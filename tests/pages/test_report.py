"""A report says what the analyses say, and stands alone: one page, nothing fetched, no name becomes markup."""

import html
import math
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.errors import MissingProgram
from rattle.pages import print_pdf
from rattle.pages.report_html import handy
from rattle.pages.report_model import assumed_by

TOO_FAR = """format = 1
name = "too far"
ground.points = { O = [0, 0] }
bodies.a = { bar = ["O", "A"], length = 1, mass = 1 }
joints.O = { type = "revolute", connect = ["ground.O", "a.O"] }
drivers.d = { joint = "O", angle = "sqrt(0.5 - t)" }
simulate.t_end = 1
"""
VOID = {"meta", "br", "link", "path", "use", "image", "rect", "circle", "ellipse", "line", "polygon", "polyline"}


class Page(HTMLParser):
    """Elements, ids, texts and links of a page; it notes elements that are not closed in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.wrong, self.ids, self.tags, self.links, self.text = [], [], [], [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.tags.append(tag)
        self.ids += [attrs["id"]] if "id" in attrs else []
        self.links += [attrs[key] for key in ("src", "href", "xlink:href") if key in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag in VOID:
            return
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data):
        if "style" not in self.open[-1:]:
            self.text += data


def write(m, folder, **options):
    path = m.report(folder / "report.html", **options)
    text = path.read_text(encoding="utf-8")
    page = Page(text)
    assert page.wrong == []
    assert page.open == []
    assert len(page.ids) == len(set(page.ids)), "names clash"
    assert all(link.startswith(("#", "data:")) for link in page.links), "something is fetched"
    assert {link[1:] for link in page.links if link.startswith("#")} <= set(page.ids)
    assert "@import" not in text
    assert "<script" not in text
    assert len(text) < 2_000_000
    return page


@pytest.fixture(scope="module")
def fourbar(tmp_path_factory):
    return write(rt.example("fourbar"), tmp_path_factory.mktemp("report"), t_end="0.3 s", author="A. Nobody")


def test_the_report_has_the_numbers_of_the_run(fourbar):
    r = rt.example("fourbar").simulate("0.3 s", horizon=True)
    force = r.peak("O4.force")[0]
    assert handy(force, "N") in fourbar.text
    for joint in ("O2", "O3", "O4"):  # a star: after the horizon, which machines reach with other roundings
        when = r.peak(f"{joint}.force")[1]
        assert (f"{handy(when, 's')} *" in fourbar.text) == (when > r.trust.horizon)
    assert handy(r.rms("O4.force"), "N") in fourbar.text
    assert "one of many possible" in fourbar.text
    ideal = rt.example("fourbar").ideal().simulate("0.3 s").peak("O4.force")[0]
    assert f"{force / ideal:.3g}" in fourbar.text


def test_what_cannot_be_vouched_for_is_said(fourbar):
    r = rt.example("fourbar").simulate("0.3 s", horizon=True)
    vouched = fourbar.text[fourbar.text.index("What this report cannot vouch for") :]
    assert f"{r.trust.horizon:.3g} s (horizon)" in vouched
    assert "would have to pull" in vouched
    assert len(r.trust.doubts()) == 2
    assert [one.partition(":")[0] for one in r.trust.holds()] == ["the equations were solved well"]


def test_the_report_holds_model_assumptions_versions_and_the_way_it_was_made(fourbar):
    for words in (
        "A. Nobody", rt.__version__, np.__version__, "Everything happens in one plane", "l2", "0.5 m to 0.8 m",
        "±0.2 mm", "angle = omega*t", assumed_by(rt.example("fourbar").model.joints["O3"].contact),
        "rattle report model.toml",
        "Oil films: no joint has oil.", rt.example("fourbar").to_toml(),
    ):  # fmt: skip
        assert words in fourbar.text, words
    assert fourbar.tags.count("svg") == fourbar.tags.count("figure") > 6


def test_contacts_and_impacts_are_told(tmp_path):
    m = rt.example("slider_crank_play")
    page = write(m, tmp_path, t_end="6 ms")
    r = m.simulate("6 ms")
    assert f"B: touches {r.contacts['B'].contacts} times" in page.text
    assert handy(r.contacts["B"].peak, "N") in page.text
    assert "Lankarani" in page.text
    assert "Path of the pin of B" in page.text


def test_oil_is_told(tmp_path):
    m = rt.example("slider_crank_oil")
    page = write(m, tmp_path, t_end="6 ms")
    film = m.simulate("6 ms").films["B"]
    assert f"{1e6 * film.least_film:.4g} µm" in page.text
    assert "one viscosity for the whole film" in page.text


@pytest.mark.parametrize(
    ("play", "row"),
    [
        ('clearance = { fit = "H7/g6", diameter = "8 mm" }', ("O.pin", "−9.5 µm", "±4.5 µm")),
        ('bearing = "6208 C3"', ("O.play", "12 µm", "±4.5 µm")),
    ],
)
def test_diameters_of_a_fit_are_in_the_table_of_parameters(tmp_path, play, row):
    """Also of a file that has no table of parameters of its own."""
    text = f"""
format = 1
ground.points.O = [0, 0]
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1e-3 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "pin.P"], {play}, contact = "massless-link" }}
"""
    page = write(rt.loads(text), tmp_path, t_end="1 us")
    at = page.text.index(row[0])
    assert page.text.rindex("Parameters", 0, at) > 0
    assert all(word in page.text[at : at + 60] for word in row)
    assert "follow from others" not in page.text


def test_a_mechanism_at_rest_has_its_equilibria(tmp_path):
    m = rt.example("balanced_arm")
    page = write(m, tmp_path, t_end="0.5 s")
    assert "Small vibrations about the first equilibrium" in page.text
    assert f"{m.modes().frequency[0]:.4g}" in page.text
    assert "nothing drives" not in page.text
    assert "no joint has play" in page.text


def test_a_motion_that_fails_is_said_at_the_top(tmp_path):
    page = write(rt.loads(TOO_FAR), tmp_path)
    at = page.text.index("This needs attention.")
    assert at < page.text.index("How far this can be trusted")
    assert "The motion ends early, at t = 0.5" in page.text[at:]


def test_a_mechanism_that_does_not_close_has_a_report_too(tmp_path):
    page = write(rt.example("quick_return").set(height="700 mm"), tmp_path)
    assert "This needs attention." in page.text
    assert "open by" in page.text  # in the drawing
    assert "Joint forces" not in page.text


def test_the_command_writes_the_command_that_made_it_without_folders(tmp_path):
    target = tmp_path / "own report.html"
    words = [
        "report",
        "slider_crank",
        "--set",
        "speed=3000 rpm",
        "--t-end",
        "1 ms",
        "--author",
        "me",
        "-o",
        str(target),
    ]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    page = Page(target.read_text(encoding="utf-8"))
    typed = "rattle report slider_crank --set 'speed=3000 rpm' --t-end 0.001 --author me -o 'own report.html'"
    assert typed in page.text
    assert str(tmp_path) not in page.text
    assert '"3000 rpm"' in page.text  # the model of the appendix


def test_a_motion_that_fails_is_exit_status_1_and_has_its_report(tmp_path):
    model, target = tmp_path / "far.toml", tmp_path / "far.html"
    model.write_text(TOO_FAR, encoding="utf-8")
    done = CliRunner().invoke(main, ["report", str(model), "-o", str(target)])
    assert done.exit_code == 1
    assert "ends early" in done.output
    assert "This needs attention" in target.read_text(encoding="utf-8")
    assert CliRunner().invoke(main, ["report", str(model), "-o", str(model)]).exit_code == 2


def test_names_are_text(tmp_path):
    bad = '</title></style><script>alert(1)</script>&"<b>'
    m = rt.example("slider_crank").set({"name": bad})
    page = write(m, tmp_path, author="<i>me</i>", t_end="1 ms")
    assert "script" not in page.tags
    assert "b" in page.tags  # of captions
    assert bad in html.unescape(page.text)
    assert "<i>me</i>" in page.text


def test_numbers_are_in_handy_units():
    assert handy(49270.0, "N") == "49.27 kN"
    assert handy(0.0002514, "s") == "0.2514 ms"
    assert handy(-1.5e-5, "m") == "\N{MINUS SIGN}15 µm"
    assert handy(0.0, "J") == "0 J"
    assert handy(math.pi / 6, "rad") == "30 deg"


def test_bad_names_and_missing_browsers_are_refused_before_anything_runs(tmp_path, monkeypatch):
    m = rt.example("fourbar")
    with pytest.raises(ValueError, match="a name ending in"):
        m.report(tmp_path / "report.txt")
    with pytest.raises(ValueError, match="A4 or Letter"):
        m.report(tmp_path / "report.html", paper="A3")
    monkeypatch.setattr(print_pdf, "browser", lambda: None)
    with pytest.raises(MissingProgram, match=r"write report\.html instead, open it in any browser and print it"):
        m.report(tmp_path / "report.pdf")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(print_pdf.browser() is None, reason="no browser that prints")
def test_a_browser_prints_it(tmp_path):
    path = rt.example("slider_crank").report(tmp_path / "report.pdf", t_end="2 ms")
    data = path.read_bytes()
    assert data.startswith(b"%PDF")
    assert int(re.search(rb"/Count (\d+)", data)[1]) > 3  # pages


def test_a_report_is_written_in_the_units_that_were_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, ["-q", "report", "slider_crank", "--units", "cm,kN", "-o", "r.html"])
    assert done.exit_code == 0, done.output
    text = Page((tmp_path / "r.html").read_text(encoding="utf-8")).text
    force, _ = rt.example("slider_crank").simulate().peak("O.force")
    assert f"{1e-3 * force:.4g} kN" in text
    assert "A (5 cm, 0 cm)" in text
    assert "rattle report slider_crank --units cm,kN -o r.html" in text


@pytest.mark.parametrize(
    "name", [pytest.param(x, marks=() if x == "press" else pytest.mark.long) for x in rt.examples()]
)
def test_every_example_has_a_report(tmp_path, name):
    page = write(rt.example(name), tmp_path)
    assert "How far this can be trusted" in page.text
    assert "This needs attention" not in page.text
