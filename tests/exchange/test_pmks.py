"""Links of PMKS+: bodies lie where they are drawn, turn and slide as the page has them move."""

import math
import re

import numpy as np
import pytest

import foreign_texts as foreign
import rattle as rt
from foreign_texts import INPUT, SLIDER, STILL, WELDED, pmks, pmks_fourbar
from rattle.exchange.imported import Assumptions
from rattle.exchange.pmks.link import CHECKS, read_link
from rattle.exchange.pmks.read import read_pmks
from rattle.exchange.writing import text_of

# templates of PMKS+ (templates.component.ts): a slider-crank, and an older link that ends behind its force
TEMPLATE = (
    "0P.TY.K,0.101.MA,A,0mA,0c,0.GB,B,0Yt,bK,0.GC,C,il,H-,0.LD,D,il,H-,0..YRAB,AB,Fe,Fe,0fW,IN,c5cae9,A,B,,.YRBC,BC,Fe,"
    "Fe,4y,Rf,303e9f,B,C,,.YPCD,CD,Fe,0,0,0,,C,D,,...JAe"
)
OLDER = (
    "0v.cc.K,0.101.Ma,a,0,0,0.Gb,b,fk,1Jz,0.Gc,c,2o7,1sD,0.Kd,d,3Qm,0,0..YRab,Crank,Fe,Fe,Kt,f-,c5cae9,a,b,,.YRbc,"
    "Coupler,Fe,Fe,1jw,1b5,303e9f,b,c,,.YRcd,Follower,Fe,Fe,36S,x7,c5cae9,c,d,,..2F1,bc,F1,1AR,1SH,1AR,JF,Fe.R"
)


def imported(link: str):
    return read_pmks(f"pmks:{link}", "a.pmks", Assumptions())


def mechanism(link: str):
    return rt.loads(text_of(imported(link)))


def body(name: str, ends: str, mass: float = 1.0, kind: str = "R", **more):
    """A link of a link, for `pmks`."""
    return (
        name,
        mass,
        more.get("inertia", 0.01),
        more.get("center", (0, 0)),
        ends,
        kind,
        more.get("root", True),
        more.get("parts", ""),
    )


def test_bodies_and_their_masses_are_where_they_are_drawn():
    m = mechanism(pmks_fourbar(speed=30))
    r = m.kinematics([0.0])
    for point, x, y in (("AB.A", -0.12, -0.04), ("AB.B", -0.12, 0.02), ("BC.C", 0.04, 0.1), ("CD.D", 0.08, -0.04)):
        assert (r[f"{point}.x"][0], r[f"{point}.y"][0]) == pytest.approx((x, y), abs=1e-15)
    for name, x, y in (("AB", -0.12, -0.01), ("BC", -0.04, 0.06), ("CD", 0.06, 0.03)):
        assert (r[f"{name}.x"][0], r[f"{name}.y"][0]) == pytest.approx((x, y), abs=1e-15)
    assert {n: (b.mass, b.inertia) for n, b in m.model.bodies.items()} == {
        "AB": (0.1, 0.003),
        "BC": (0.3, 0.012),
        "CD": (0.2, 0.005),
    }


@pytest.mark.parametrize(("clockwise", "omega"), [(False, math.pi), (True, -math.pi)])
def test_the_motor_turns_at_its_speed(clockwise, omega):
    r = mechanism(pmks_fourbar(speed=30, clockwise=clockwise)).kinematics([0.0, 0.2])
    np.testing.assert_allclose(r["AB.omega"], omega, rtol=1e-14)


@pytest.mark.parametrize(("unit", "metres"), [(0, 0.0254), (1, 0.01), (2, 1.0)])
def test_lengths_are_in_the_unit_of_the_link(unit, metres):
    read = imported(pmks_fourbar(unit=unit))
    assert read.document["bodies"]["BC"]["points"]["B"] == pytest.approx([-0.12 * metres, 0.02 * metres], rel=1e-15)
    assert any(
        ("in", "cm", "m")[unit] in word.split() or f"{('in', 'cm', 'm')[unit]}," in word for word in read.assumed
    )


def test_gravity_is_taken_where_it_is_switched_on():
    assert imported(pmks_fourbar()).document["gravity"] == [0.0, 0.0]
    assert imported(pmks_fourbar(gravity=True)).document["gravity"] == [0.0, -9.81]


@pytest.mark.parametrize("still", [0, STILL])
@pytest.mark.parametrize("angle", [0.0, 0.3, -1.2])
def test_a_piston_slides_on_its_line(still, angle):
    c, s = round(0.12 * math.cos(angle), 3), round(0.12 * math.sin(angle), 3)
    b = (round(-0.05 * math.sin(angle), 3), round(0.05 * math.cos(angle), 3))
    joints = [("A", 0, 0, INPUT | STILL, 0), ("B", *b, 0, 0), ("C", c, s, 0, 0), ("D", c, s, SLIDER | still, angle)]
    m = mechanism(pmks(joints, [body("AB", "AB"), body("BC", "BC"), body("CD", "CD", kind="P", inertia=0)], speed=60))
    r = m.kinematics(np.linspace(0, 0.9, 7))
    rod, turned = math.dist(b, (c, s)), math.atan2(b[1], b[0]) + math.tau * r.t
    u, n = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    pin = math.hypot(*b) * np.array([np.cos(turned), np.sin(turned)])
    off = n @ [c, s]  # of the line from the axis
    want = u @ pin + np.sqrt(rod**2 - (n @ pin - off) ** 2)
    np.testing.assert_allclose(u @ [r["CD.x"], r["CD.y"]], want, atol=1e-12)
    np.testing.assert_allclose(r["CD.angle"], 0.0, atol=1e-12)


def test_a_slider_that_is_driven_moves_at_the_speed_of_the_link():
    joints = [("A", 0, 0, STILL, 0), ("B", 0, 50, 0, 0), ("C", 120, 0, 0, 0), ("D", 120, 0, SLIDER | STILL | INPUT, 0)]
    r = mechanism(
        pmks(joints, [body("AB", "AB"), body("BC", "BC"), body("CD", "CD", kind="P")], speed=7, unit=1, clockwise=True)
    ).kinematics([0.0, 0.4])
    np.testing.assert_allclose(r["CD.vx"], -0.07, rtol=1e-12)


def test_bodies_that_meet_at_a_joint_have_a_pin_fewer_than_they_are():
    joints = [("A", -0.12, -0.04, INPUT | STILL, 0), ("B", -0.12, 0.02, 0, 0), ("C", 0.04, 0.1, 0, 0),
              ("D", 0.08, -0.04, STILL, 0), ("E", 0.2, 0.1, 0, 0), ("F", 0.2, -0.04, STILL, 0)]  # fmt: skip
    links = [body(name, name) for name in ("AB", "BC", "CD", "CE", "EF")]
    table = imported(pmks(joints, links)).document["joints"]
    there = [entry["connect"] for entry in table.values() if any(end.endswith(".C") for end in entry["connect"])]
    assert there == [["BC.C", "CD.C"], ["BC.C", "CE.C"]]
    assert len(table) == 7


def test_links_that_are_welded_are_one_body_with_one_mass_centre():
    joints = [
        ("A", 0, 0, INPUT | STILL, 0),
        ("B", 0, 0.1, 0, 0),
        ("C", 0.3, 0.1, WELDED, 0),
        ("E", 0.3, 0.3, 0, 0),
        ("D", 0.4, 0, STILL, 0),
    ]
    links = [body("AB", "AB"), body("BC", "BC", 3.0, center=(0.15, 0.1), inertia=0.02),
             body("CE", "CE", 1.0, center=(0.3, 0.2), inertia=0.005), body("ED", "ED")]  # fmt: skip
    m = mechanism(pmks(joints, links))
    whole = m.model.bodies["BC_CE"]
    x, y = (3 * 0.15 + 0.3) / 4, (3 * 0.1 + 0.2) / 4
    spread = 3 * ((0.15 - x) ** 2 + (0.1 - y) ** 2) + (0.3 - x) ** 2 + (0.2 - y) ** 2
    assert (whole.mass, whole.inertia) == pytest.approx((4.0, 0.025 + spread), rel=1e-12)
    r = m.kinematics([0.0])
    assert (r["BC_CE.x"][0], r["BC_CE.y"][0]) == pytest.approx((x, y), abs=1e-14)
    assert len(m.model.joints) == 4


def test_a_compound_link_without_a_mass_has_that_of_its_parts():
    joints = [
        ("A", 0, 0, INPUT | STILL, 0),
        ("B", 0, 0.1, 0, 0),
        ("C", 0.3, 0.1, WELDED, 0),
        ("E", 0.3, 0.3, 0, 0),
        ("D", 0.4, 0, STILL, 0),
    ]
    parts = [
        body("BC", "BC", 3.0, center=(0.15, 0.1), inertia=0.02, root=False),
        body("CE", "CE", 1.0, center=(0.3, 0.2), root=False),
    ]
    whole = body("BCE", "BCE", 0.0, inertia=0, parts=("BC", "CE"))
    m = mechanism(pmks(joints, [body("AB", "AB"), whole, body("ED", "ED"), *parts]))
    assert set(m.model.bodies) == {"AB", "BCE", "ED"}
    assert m.model.bodies["BCE"].mass == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("link", "bodies", "left"),
    [(TEMPLATE, {"AB", "BC", "CD"}, ()), (OLDER, {"Crank", "Coupler", "Follower"}, ("force F1",))],
)
def test_links_of_the_page_itself_assemble_and_run(link, bodies, left):
    read = imported(link)
    m = rt.loads(text_of(read))
    assert (set(m.model.bodies), read.left_out) == (bodies, left)
    r = m.simulate(0.02)
    assert r.success
    assert r.trust.drift < 1e-9


@pytest.mark.parametrize("text", [
    "pmks:{}\n", "PMKS: {}", "https://app.pmksplus.com/?{}", "http://localhost:4200/index.html?{}", "\ufeffpmks:{}\r\n",
    "[InternetShortcut]\r\nURL=https://app.pmksplus.com/?{}\r\n",
])  # fmt: skip
def test_a_link_is_behind_pmks_or_in_an_address(text):
    assert read_pmks(text.format(TEMPLATE), "a.url", Assumptions()).document == imported(TEMPLATE).document


def test_names_with_blanks_come_through_an_address():
    named = OLDER.replace("Follower", "Außen arm")
    link = named[:-1] + CHECKS[len(named[:-1]) % 62]
    address = "https://app.pmksplus.com/?" + link.replace(" ", "%20").replace("ß", "%C3%9F")
    for text in (address, f"pmks:{link}", address.replace("https://app.pmksplus.com/?", "pmks:")):
        assert any("arm" in name for name in read_pmks(text, "a", Assumptions()).document["bodies"])


def test_numbers_have_sixty_four_digits_and_a_leading_nought_is_a_minus():
    link = read_link(pmks([("A", -4.096, 262.144, STILL, 0), ("B", 0, 1e6, 0, 0)], [body("AB", "AB")]), "a")
    assert [joint.x.thousandths for joint in link.joints] == [-4096, 0]
    assert [joint.y.thousandths for joint in link.joints] == [262144, 10**9]


def refusal(text: str) -> str:
    with pytest.raises(rt.ModelError) as caught:
        read_pmks(text, "a.pmks", Assumptions())
    words = str(caught.value)
    assert re.fullmatch(r"a\.pmks(:1)?: [^\n]+", words), words
    return words


def checked(link: str) -> str:
    return f"pmks:{link}{CHECKS[len(link) % 62]}"


def changed(old: str, new: str) -> str:
    """The template with a part replaced, and its check."""
    assert old in TEMPLATE
    return checked(TEMPLATE[:-1].replace(old, new))


@pytest.mark.parametrize(("text", "says"), [
    ("pmks:", "empty"), ("pmks:" + TEMPLATE[:-1] + "A", "check"), ("pmks:" + TEMPLATE[:30] + TEMPLATE[31:], "check"),
    ("https://app.pmksplus.com/", "question mark"), ("hello", "not a link"), ("pmks:a\npmks:b", "2 lines"),
    (checked("0P.TY"), "settings"), (checked(TEMPLATE[:90]), "joints|links|link"),
    (changed("A,B,,", "A,X,,"), "X"), (changed("0mA", "0m!"), "joint A"), (changed("YRAB", "YQAB"), "link 1"),
    (changed(".101.", ".901."), "unit"), (changed("GB,B", "GA,B"), "two joints"),
    (changed("Fe,Fe", "0Fe,Fe"), "negative"),
    (checked("0P.TY.K,0.101....NA"), "no mechanism"), (checked(OLDER[:-1].replace("2F1,bc", "2F1,zz")), "zz"),
])  # fmt: skip
def test_what_cannot_be_read_is_refused_by_its_place(text, says):
    assert re.search(says, refusal(text))


def test_a_link_cut_off_anywhere_is_refused_by_its_check():
    kept = [at for at in range(1, len(TEMPLATE)) if TEMPLATE[at - 1] == CHECKS[(at - 1) % 62]]
    for at in range(1, len(TEMPLATE)):
        if at not in kept:
            refusal("pmks:" + TEMPLATE[:at])
    assert len(kept) < 6  # the length alone is checked


def test_forces_are_left_out_by_name():
    force = f"0F1,AB,Push,{foreign.thousandths(0)},0,0,{foreign.thousandths(1)},{foreign.thousandths(5)}"
    assert imported(pmks_fourbar(forces=[force])).left_out == ("force Push",)
