"""What the editor of the studio offers where the caret is, and what it adds to a model."""

import json
import random
import tomllib
from pathlib import Path

import pytest
from studio_models import PENDULUM

import rattle as rt
from browsing import becomes, shows
from rattle.description.schema import schema
from rattle.loading import examples
from rattle.pages.viewer_text import joined
from rattle.studio.completion import entries

SCRIPTS = Path(rt.__file__).parent / "studio" / "page"

OFFERED = """() => {
  const list = document.querySelector(".suggest");
  return list.hidden ? null : [...list.querySelectorAll("li b")].map((one) => one.textContent);
}"""
DOUBLE = """
[bodies.link]
bar = ["C", "D"]
length = "0.2 m"
mass = 1
points = { E = [0, 0] }

[joints.P]
type = "revolute"
connect = ["rod.B", "link.C"]

[drivers.motor]
joint = "O"
angle = "t"
"""


# ------------------------------------------------------------ the pieces, without a studio
@pytest.fixture
def pieces(open_page):
    """A page with the reader of texts and what may stand where."""
    files = {file.name: file.read_text(encoding="utf-8") for file in SCRIPTS.glob("*.js")}
    page = open_page("about:blank")
    page.evaluate(
        """async ([text, entries, told]) => {
          const load = (code) => import(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
          window.outline = (await load(text)).outline;
          window.entries = new (await load(entries)).Entries(told);
        }""",
        [joined(files, "outline.js"), joined(files, "entries.js"), entries()],
    )
    return page


def shape(value):
    """Keys of tables and lengths of arrays."""
    if isinstance(value, dict):
        return {key: shape(one) for key, one in value.items()}
    return [shape(one) for one in value] if isinstance(value, list) else 0


SHAPE = """(text) => {
  const shape = (value) => value instanceof Map ? Object.fromEntries([...value].map(([key, one]) => [key, shape(one)]))
    : Array.isArray(value) ? value.map(shape) : 0;
  return shape(outline(text, 0).root);
}"""
MORE = '''a.b.c = 1\n"quoted key" = 'x # no comment'\nlong = """\n[no.header]\nx = 1"""\nlist = [ # all
  [1, 2],
  { x = "]", y = [3] },
]\n[t."d e"]\nz = { u.v = 1 }\n'''


def test_texts_are_read_as_the_reader_of_toml_reads_them(pieces):
    for text in [MORE, *(path.read_text(encoding="utf-8") for path in examples().values())]:
        assert pieces.evaluate(SHAPE, text) == shape(tomllib.loads(text))


def test_every_key_of_every_example_is_offered_where_it_stands(pieces):
    check = """(text) => {
      const { root } = outline(text, 0), missing = [];
      const walk = (table, path) => {
        for (const [key, value] of [...table]) {
          if (entries.at(root, path).parts.some((part) => part.keys)) {
            table.delete(key);
            if (!entries.keys(root, path).some((one) => one.label === key)) missing.push([...path, key].join("."));
            table.set(key, value);
          }
          if (value instanceof Map) walk(value, [...path, key]);
        }
      };
      walk(root, []);
      return missing;
    }"""
    for path in examples().values():
        assert pieces.evaluate(check, path.read_text(encoding="utf-8")) == []


FITTED = """
[materials.mine]
E = 1e11
[joints.O]
type = "revolute"
clearance = { fit = "", bush_material = "" }
bearing = ""
contact = { model = "lubricated", oil = "" }
"""


def test_fits_bearings_oils_and_materials_are_offered_by_name(pieces):
    offered = """([text, path]) => { const { root } = outline(text, 0);
      return entries.values(root, path).map((value) => value.label); }"""
    by_name = {
        ("joints", "O", "clearance", "fit"): {"H7/g6", "H7/h6"},
        ("joints", "O", "clearance", "bush_material"): {"mine", "bronze", "steel"},
        ("joints", "O", "bearing"): {"6208", "6208 C3"},
        ("joints", "O", "contact", "oil"): {"ISO VG 46", "ISO VG 100"},
    }
    for path, some in by_name.items():
        labels = pieces.evaluate(offered, [FITTED, list(path)])
        assert some <= set(labels), path
    for name in pieces.evaluate(offered, [FITTED, ["joints", "O", "clearance", "fit"]]):
        assert rt.fit(name, "8 mm").radial > 0.0


def test_texts_that_are_cut_or_mixed_are_read_to_their_end(pieces):
    draw = random.Random(25)
    signs = ["[", "]", "{", "}", '"', "'", "=", ".", ",", "\n", "#", '"""', " ", "__proto__", "a"]
    texts = ["".join(draw.choices(signs, k=60)) for _ in range(400)]
    whole = [path.read_text(encoding="utf-8") for path in examples().values()]
    for _ in range(100):
        text = draw.choice(whole)
        k = draw.randrange(len(text))
        texts.append(text[:k] + draw.choice(signs) + text[k + draw.randrange(20) :])
    texts += [
        "x = " + "[" * 20_000,
        "x = " + "{ a = " * 20_000,
        "[" * 20_000,
        '"' * 9_999,
        "__proto__ = 1\n[constructor]\n",
    ]
    places = pieces.evaluate(
        "(all) => all.map(([text, at]) => { const { place, root } = outline(text, at);"
        " if (place.path) { entries.keys(root, place.path); entries.values(root, place.path); } return place.kind; })",
        [[text, draw.randrange(len(text) + 1)] for text in texts],
    )
    assert set(places) == {"key", "value", "header", "none"}


def test_the_small_schema_says_what_the_schema_says():
    told = entries()
    parts = told["parts"]

    def same(number, part):
        small = parts[number]
        assert small.get("about") == part.get("description")
        assert small.get("required", []) == part.get("required", [])
        assert list(small.get("keys", {})) == list(part.get("properties", {}))
        for key, one in small.get("keys", {}).items():
            same(one, part["properties"][key])
        assert len(small.get("either", [])) == len(part.get("anyOf", []))
        for one, other in zip(small.get("either", []), part.get("anyOf", []), strict=True):
            same(one, other)

    same(told["whole"], schema())
    assert len(json.dumps(told)) < 0.1 * len(json.dumps(schema()))  # it is sent to every page


# ------------------------------------------------------------ in the studio
@pytest.fixture
def editor(open_page, studio):
    """A function that opens the studio at its text, with this text in it."""

    def opened(text, **options):
        (studio.folder / "edited.toml").write_text(text)
        page = open_page("about:blank", **options)
        page.add_init_script("localStorage.setItem('rattle-studio-hints', 'seen')")
        page.goto(studio.new_address())
        becomes(page, "window.rattle && window.rattle.names.length > 5")
        page.get_by_role("tab", name="Text").click()
        page.locator("textarea.area").fill(text)
        becomes(page, "() => document.querySelector('.editor').dataset.ready === 'true'")
        return page

    yield opened
    (Path(studio.folder) / "edited.toml").unlink(missing_ok=True)


def text_of(page):
    return page.locator("textarea.area").input_value()


def caret_after(page, words):
    page.evaluate(
        """(words) => {
          const area = document.querySelector("textarea.area"), at = area.value.indexOf(words) + words.length;
          area.focus();
          area.setSelectionRange(at, at);
        }""",
        words,
    )


def offered(page):
    """What the list offers, without what can be added anywhere."""
    page.keyboard.press("Control+Space")
    return [one for one in page.evaluate(OFFERED) or [] if not one.startswith("add ")]


def test_keys_of_the_section_choices_and_names_are_offered(editor):
    page = editor(PENDULUM + DOUBLE)
    joints = {
        one["properties"]["type"]["const"]: one
        for one in schema()["properties"]["joints"]["additionalProperties"]["anyOf"]
    }
    caret_after(page, 'connect = ["rod.B", "link.C"]\n')
    assert set(offered(page)) == set(joints["revolute"]["properties"]) - {"type", "connect"}
    caret_after(page, '[joints.P]\ntype = "')
    assert set(offered(page)) == {name for name, one in joints.items() if "connect" in one["properties"]}
    caret_after(page, 'connect = ["rod.B", "')
    m = rt.loads(PENDULUM + DOUBLE)
    assert set(offered(page)) == {"ground.O", "rod.A", "rod.B", "link.C", "link.D", "link.E"}
    caret_after(page, 'joint = "')
    assert offered(page) == list(m.model.joints)
    caret_after(page, 'length = "')
    assert offered(page) == list(m.model.parameters)
    caret_after(page, "# a pendulum")
    assert offered(page) == []
    shows(page.get_by_text("Nothing is offered here"))


def test_what_is_chosen_is_written_and_undone_at_once(editor):
    page = editor(PENDULUM)
    caret_after(page, "mass = 1\n")
    page.keyboard.type("iner")
    becomes(page, f"() => ({OFFERED})()?.join() === 'inertia'")
    page.keyboard.press("Escape")
    becomes(page, f"() => ({OFFERED})() === null")
    assert page.evaluate("() => document.activeElement.matches('textarea.area')")  # Escape closed the list alone
    page.keyboard.press("Control+Space")
    page.keyboard.press("Tab")
    before = PENDULUM.replace("mass = 1\n", "mass = 1\ninertia = ")
    assert text_of(page) == before
    page.keyboard.type("2")
    page.get_by_role("toolbar").get_by_role("button", name="parameter").click()
    assert "a = { value" in text_of(page)
    page.keyboard.press("Control+z")
    assert text_of(page) == before.replace("inertia = ", "inertia = 2")
    page.keyboard.press("Control+z")
    assert text_of(page) == before
    page.keyboard.type("2")  # the caret is where the text has changed
    assert text_of(page) == before.replace("inertia = ", "inertia = 2")
    page.get_by_label("l, value with unit").fill("1.5 m")
    page.get_by_label("l, value with unit").press("Enter")
    becomes(page, "() => document.querySelector('textarea.area').value.includes('\"1.5 m\"')")
    page.keyboard.press("Control+z")  # the knob
    assert text_of(page) == before.replace("inertia = ", "inertia = 2")
    page.keyboard.press("Control+z")  # the digit
    assert text_of(page) == before


@pytest.mark.parametrize("touched", [False, True])
def test_an_entry_of_the_list_is_taken_by_mouse_and_finger(editor, touched):
    page = editor(PENDULUM, has_touch=touched)
    caret_after(page, '[joints.O]\ntype = "')
    page.keyboard.press("Control+Space")
    entry = page.get_by_role("option", name="fixed")
    entry.tap() if touched else entry.click()
    assert text_of(page) == PENDULUM.replace('"revolute"', '"fixed"')
    page.keyboard.type(" ")  # the text has the focus, and the caret is behind the word
    assert text_of(page) == PENDULUM.replace('"revolute"', '"fixed" ')


@pytest.mark.parametrize("wanted", ['[joints.O]\ntype = "', 't_end = "1 s"\n'])
def test_the_list_is_in_sight_wherever_the_caret_is(editor, wanted):
    page = editor("# a line\n" * 200 + PENDULUM, viewport={"width": 844, "height": 390}, is_mobile=True, has_touch=True)
    caret_after(page, wanted)
    page.get_by_role("button", name="what fits here?").tap()
    inside = """() => {
      const box = (name) => document.querySelector(name).getBoundingClientRect();
      const list = box(".suggest"), sheet = box(".sheet");
      return list.height > 50 && list.top >= sheet.top - 1 && list.bottom <= sheet.bottom + 1
        && list.right <= sheet.right;
    }"""
    becomes(page, inside)


def test_a_quotation_mark_is_not_written_twice(editor):
    page = editor(PENDULUM)
    caret_after(page, 'connect = ["ground.O", "rod.A"]\n')
    page.keyboard.type("cont")
    page.keyboard.press("Enter")
    page.keyboard.type('impact"\nclearance = "1 mm"')
    becomes(page, f"() => ({OFFERED})() === null")
    assert '"rod.A"]\ncontact = "impact"\nclearance = "1 mm"\n' in text_of(page)


def test_names_of_the_users_own_are_typed_without_a_list(editor):
    page = editor(PENDULUM)
    caret_after(page, "[parameters]\n")
    page.keyboard.type("f")
    assert page.evaluate(OFFERED) is None


def test_every_addition_makes_a_sound_model_of_a_sound_one(editor):
    page = editor(PENDULUM)
    texts = [PENDULUM]
    for _ in range(2):
        for part in ("body", "joint", "block", "slider", "spring", "force", "driver", "play in a joint", "parameter"):
            page.get_by_role("toolbar").get_by_role("button", name=part, exact=True).click()
            texts.append(text_of(page))
            assert texts[-1] != texts[-2]
            m = rt.loads(texts[-1])
    assert len(m.model.bodies) == 5
    assert len(m.model.joints) == 5
    assert len(m.model.loads) == 4
    assert "# a pendulum; this comment stays" in texts[-1]
    for text in reversed(texts[:-1]):
        page.keyboard.press("Control+z")
        assert text_of(page) == text


def test_an_addition_is_found_by_typing_its_name(editor):
    page = editor(PENDULUM)
    caret_after(page, "mass = 1\n")
    page.keyboard.type("sprin")
    becomes(page, f"() => ({OFFERED})()?.join() === 'add spring'")
    page.keyboard.press("Enter")
    assert "sprin\n" not in text_of(page)
    assert list(rt.loads(text_of(page)).model.loads) == ["spring"]


def test_a_section_is_gone_to_from_the_list_of_sections(editor):
    page = editor("# a line\n" * 60 + PENDULUM + "# a line\n" * 60)
    places = page.get_by_label("Go to a section")
    places.focus()
    heads = [line.strip("[]").replace(".", " . ") for line in PENDULUM.splitlines() if line.startswith("[")]
    assert places.locator("option").all_text_contents()[1:] == heads
    places.select_option(heads[-1])
    becomes(
        page,
        """() => {
          const root = document, sheet = root.querySelector(".sheet").getBoundingClientRect();
          const line = [...root.querySelectorAll(".paint > div")].findLast((one) => one.textContent.startsWith("["));
          return Math.abs(line.getBoundingClientRect().top - sheet.top) < 20;
        }""",
    )
    page.keyboard.type("# here\n")
    assert text_of(page).index("# here\n") == 9 * 60 + PENDULUM.rindex("\n[") + 1


@pytest.mark.parametrize("width", [390, pytest.param(1366, marks=pytest.mark.long)])
def test_long_lines_are_wrapped_and_colours_lie_under_the_letters(editor, width):
    long = (
        PENDULUM
        + "# "
        + "a long line of words " * 30
        + "\n# "
        + "x" * 500
        + "\n"
        + 'wrong = "'
        + "y" * 300
        + '"\n'
        + "# end\n" * 40
    )
    page = editor(long, viewport={"width": width, "height": 844})
    shows(page.locator(".problem").first)
    sizes = page.evaluate(
        """() => {
          const root = document, area = root.querySelector("textarea.area"), sheet = root.querySelector(".sheet");
          const painted = root.querySelector(".paint").offsetHeight, wide = [sheet.scrollWidth, sheet.clientWidth];
          area.style.height = "1px";
          const written = area.scrollHeight;
          area.style.height = "";
          return [painted, written, ...wide];
        }"""
    )
    assert sizes[0] == sizes[1]  # every line breaks where its colours do
    assert sizes[2] == sizes[3]  # nothing is beside what is seen
    row = long.split("\n").index('wrong = "' + "y" * 300 + '"')
    assert "wrong" in page.locator(".paint > div").nth(row).get_attribute("class")
