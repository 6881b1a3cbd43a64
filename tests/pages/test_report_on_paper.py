"""A report breaks well on paper: few pages, heads with their rows, captions with their pictures, no page mostly empty.

A browser notes in a PDF the page and the height of everything to which a link leads.
"""

import re
from itertools import pairwise
from typing import NamedTuple

import pytest

import rattle as rt
from rattle.pages import print_pdf
from rattle.pages.report_html import NARROW, SHORT, table

HIGH = 842.0  # of a page [points]
MOST = 6  # pages of a report of a mechanism with three bodies
BLOCKS = "h2|h3|p|ul|pre|caption|tr|figure|figcaption"

NEEDLE = """format = 1
name = "Needle bar"
gravity = [0, -9.81]
ground.points = { O = [0, 0] }
bodies.crank = { bar = ["O", "A"], length = 0.015, mass = 0.06 }
bodies.rod = { bar = ["A", "B"], length = 0.045, mass = 0.02 }
bodies.needle = { points = { B = [0, 0], N = [0, -0.08] }, mass = 0.045, inertia = 1e-5 }
joints.O = { type = "revolute", connect = ["ground.O", "crank.O"] }
joints.A = { type = "revolute", connect = ["crank.A", "rod.A"] }
joints.B = { type = "revolute", connect = ["rod.B", "needle.B"], clearance = 2e-5, contact = "massless-link" }
joints.guide = { type = "prismatic", connect = ["ground.O", "needle.B"], axis = "-90 deg", angle = 0 }
drivers.motor = { joint = "O", angle = "100*pi*t" }
simulate = { t_end = 0.04, output = 1e-4 }
"""


class Mark(NamedTuple):
    """Where the top of an element is printed."""

    tag: str
    page: int
    height: float  # above the lower edge of the page [points]

    def is_above(self, other):
        """On the same page, in the same column, and higher."""
        return self.page == other.page and self.height > other.height


def marks_of(page, folder):
    """All marked elements in their order, with the number of pages."""
    tags = []

    def marked(match):
        tags.append(match[1])
        return f'<{match[1]} id="mark{len(tags) - 1}"'

    page = re.sub(rf"<({BLOCKS})(?=[ >])", marked, page)
    links = "".join(f'<a href="#mark{n}">.</a>' for n in range(len(tags)))
    path = folder / "report.pdf"
    print_pdf.print_pdf(page.replace("</main>", f'<p style="font: 1px/1px serif">{links}</p></main>'), path)
    data = path.read_bytes()
    places = dict(re.findall(rb"/mark(\d+) \[(\d+ 0 R) /XYZ", data))
    heights = dict(re.findall(rb"/mark(\d+) \[\d+ 0 R /XYZ \S+ ([\d.]+)", data))
    pages = re.findall(rb"\d+ 0 R", b" ".join(re.findall(rb"/Kids \[([^\]]*)\]", data)))
    leaves = [one for one in pages if one in places.values()]
    keys = [str(n).encode() for n in range(len(tags))]
    count = max(int(one) for one in re.findall(rb"/Count (\d+)", data))
    found = [Mark(tag, leaves.index(places[key]), float(heights[key])) for tag, key in zip(tags, keys, strict=True)]
    return found, count


@pytest.fixture(scope="module")
def report_of(tmp_path_factory):
    """Texts of reports by the name of an example, or "needle"; each is made once."""
    made = {}

    def text(name):
        if name not in made:
            m = rt.loads(NEEDLE) if name == "needle" else rt.example(name)
            path = m.report(tmp_path_factory.mktemp("report") / "report.html")
            made[name] = path.read_text(encoding="utf-8")
        return made[name]

    return text


@pytest.mark.skipif(print_pdf.browser() is None, reason="no browser that prints")
@pytest.mark.parametrize(
    "name",
    ["needle", *(pytest.param(f"{name}_play", marks=pytest.mark.long) for name in ("slider_crank", "crank_rocker"))],
)
def test_a_report_of_three_bodies_breaks_well(report_of, tmp_path, name):
    marks, count = marks_of(report_of(name), tmp_path)
    assert count <= MOST
    assert [one for one in pairwise(marks) if belong(*one) and not one[0].is_above(one[1])] == []
    for number in range(count - 1):
        lowest = min((one.height for one in marks if one.page == number), default=HIGH)
        assert lowest < 0.5 * HIGH, f"page {number + 1} is mostly empty"


def belong(one, other):
    """True for neighbours that must not be parted: a head and what follows, a picture and its words, rows."""
    return one.tag in ("h2", "h3", "caption") or (one.tag, other.tag) in (("figure", "figcaption"), ("tr", "tr"))


def test_short_tables_are_printed_in_one_piece_and_narrow_ones_side_by_side():
    row = ("a", "1 N")
    assert 'class="wide short narrow"' in table(("joint", "force"), [row] * SHORT)
    assert 'class="wide narrow"' in table(("joint", "force"), [row] * (SHORT + 1))
    assert 'class="wide short"' in table(("joint", "force"), [("a" * NARROW, "1 N")])


def test_small_pictures_and_narrow_tables_stand_in_columns(report_of):
    page = report_of("needle")
    gallery = page.count('<div class="gallery">')
    assert gallery >= 3  # of the model, the motion, the forces
    widths = [float(width) for width in re.findall(r"--natural: ([\d.]+)in", page)]
    assert sum(width < 3.6 for width in widths) >= len(widths) - 2  # all but the drawing and the flow of energy
    upright = page[: page.index("</b> Path of needle.N")].rpartition("<svg")[2]
    assert float(re.search(r'height="([\d.]+)pt"', upright)[1]) < 0.25 * HIGH


def test_every_scale_of_a_report_has_two_numbers_at_least():
    """The curves of three bodies, each panel low: no axis with a single number."""
    from rattle.pages.report_figures import panels
    from rattle.pages.report_study import Study

    m = rt.loads(NEEDLE)
    s = Study(m, run=m.simulate())
    names = [name for name in s.run.names if s.run.unit(name) in ("m", "rad", "rad/s", "m/s^2", "N", "N*m", "W")]
    axes = panels(s, names).axes
    for name, ax in zip(names, axes, strict=True):
        low, high = ax.get_ylim()
        assert sum(low <= one <= high for one in ax.get_yticks()) >= 2, name


def test_what_stands_above_a_panel_does_not_collide():
    from rattle.pages.report_figures import panels
    from rattle.pages.report_study import Study

    m = rt.example("three_plays")
    figure = panels(Study(m, run=m.simulate()), ["rocker.alpha", "D.force"])
    figure.draw_without_rendering()
    cut = [ax for ax in figure.axes if ax.texts]
    assert cut
    for ax in cut:
        boxes = [ax.texts[-1].get_window_extent(), ax._left_title.get_window_extent()]
        assert not boxes[0].overlaps(boxes[1]), ax.get_title(loc="left")


def test_a_peak_beyond_a_cut_axis_is_marked_at_its_edge():
    r = rt.example("slider_crank_play").simulate()
    (ax,) = r.plot("O.force", robust=True).axes
    (mark,) = (line for line in ax.lines if line.get_gid() == "largest O.force")
    low, high = ax.get_ylim()
    assert high < 0.9e-3 * r.peak("O.force")[0]  # shown in kN
    assert low <= mark.get_ydata()[0] <= high


def test_a_reason_names_the_joint_and_no_file(tmp_path):
    """A Geneva drive has no motion without play; that is told without the folders of a machine."""
    from rattle.errors import ModelError
    from rattle.pages.report_study import in_words

    with pytest.raises(ModelError) as caught:
        rt.example("geneva").ideal()
    told = in_words(caught.value)
    assert "joints.slot0, joints.slot1, joints.slot2, joints.slot3: a slot with an open end needs clearance" in told
    assert ".toml" not in told
    assert "^" not in told


def test_a_joint_that_bears_nothing_has_no_force_and_no_curve(tmp_path):
    """The guide of the jack: its load hangs on the rack alone."""
    page = rt.example("ratchet").report(tmp_path / "report.html").read_text(encoding="utf-8")
    assert re.search(r"<td>guide</td><td[^>]*>0 N</td>", page)
    assert "guide.force" not in page
