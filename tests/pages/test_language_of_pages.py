"""Pages in other languages: all that is seen or read aloud, but for names of the model and sentences of rattle."""

import json
import re

import pytest
from click.testing import CliRunner

import rattle as rt
from browsing import becomes, frames
from circling import circling
from rattle.cli.main import main
from rattle.errors import InputError
from rattle.pages.replay import SILENT, write_page
from rattle.pages.scene import scene_of
from rattle.pages.wishes import Wishes
from rattle.pages.words import LANGUAGES, table, words_in

SCENE = re.compile(r'<script type="application/json" id="scene">(.*?)</script>', re.DOTALL)
# every text that is seen, hinted or read aloud and whose language is that of the page
TEXTS = """() => {
  const texts = [], root = rattle.viewer.shadow, names = ["aria-label", "title", "placeholder", "data-empty"];
  for (const element of root.querySelectorAll("*:not(style, script)")) {
    if (element.closest("[lang]").lang !== document.documentElement.lang) continue;
    texts.push(...names.map((name) => element.getAttribute(name)));
    texts.push(...Array.from(element.childNodes).filter((node) => node.nodeType === 3).map((node) => node.data));
  }
  return [...new Set([...texts, ...window.drawn])].filter((text) => /[a-z]/i.test(text ?? ""));
}"""
DRAWN = """() => {
  window.drawn = new Set();
  const write = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
    window.drawn.add(text);
    return write.call(this, text, ...rest);
  };
}"""


def words_of(text):
    return set(re.findall(r"[A-Za-zÀ-ÿ]{3,}", text))


def opened_wide(tab):
    """Everything that a page can show, shown once: both sets of parameters, all tabs, lists, help, what is hovered."""
    becomes(tab, "() => window.rattle?.run?.t.length > 10")
    tab.evaluate(DRAWN)
    tab.evaluate("rattle.viewer.turn('forces', true), rattle.seek(rattle.viewer.motion.end)")
    tab.evaluate("rattle.choose(rattle.names.filter((name) => /^(O2|crank|rocker|O1|energy)[.]/.test(name)))")
    tab.locator(".knobs .chip", has_text=re.compile("^Vergleichen$")).click()
    becomes(tab, "() => rattle.viewer.others.length === 1")
    frames(tab)
    for name in ("orbits", "events", "curves"):
        tab.evaluate("(name) => rattle.viewer.tabs.choose(name)", name)
        frames(tab)
    for joint in ("O1", "O2", "O3"):
        tab.evaluate(
            """(joint) => {
              const { view, motion } = rattle.viewer, pose = motion.pose(rattle.time);
              const [at] = view.stage.ends(motion.geometry.joints[joint], pose), { scale, x, y } = view.view;
              view.over = [x + scale * at[0], y - scale * at[1]];
              rattle.viewer.invalidate();
            }""",
            joint,
        )
        frames(tab)


def test_a_german_page_has_no_english_words(tmp_path, open_page):
    """Of the English words of the table none is left but those that German has too, or that the model uses."""
    m = rt.example("fourbar_oil").set({"simulate.t_end": 0.03, "simulate.output": 0.001})
    m.page(tmp_path / "p.html", title="Kurbelschwinge", language="de", curves=["rocker.angle"])
    tab = open_page((tmp_path / "p.html").as_uri(), reduced_motion="reduce")
    assert tab.title() == "Kurbelschwinge"
    assert tab.evaluate("document.documentElement.lang") == "de"
    becomes(tab, "() => window.rattle?.viewer.curves.chosen.join() === 'rocker.angle'")
    opened_wide(tab)
    seen = tab.evaluate(TEXTS)
    for text in ("Kräfte", "Kurven", "Teilen", "Kurven wählen", "Abspielen (Leertaste)", "Hilfe", "Winkel [deg]"):
        assert text in seen
    assert any("Bahn des Zapfens im Öl" in text for text in seen)
    assert any(text.startswith("O1, Drehgelenk") for text in seen)
    german = {word for words in words_in("de").values() for word in words_of(words)}
    english = {word for text in table() for word in words_of(text)} - german
    names = tab.evaluate(
        """[...rattle.names, ...Object.keys(rattle.parameters),
          ...["bodies", "joints", "loads", "drivers"].flatMap((part) => Object.keys(rattle.run.geometry?.[part]
            ?? rattle.viewer.scene.geometry[part]))]"""
    )
    for text in seen:
        for name in sorted(names, key=len, reverse=True):
            text = text.replace(name, "")
        assert not words_of(text) & english, text
    assert "trusted" in tab.evaluate("rattle.viewer.shadow.querySelector('.trust [lang=en]').textContent")


@pytest.mark.parametrize(
    ("width", "height", "language"),
    [
        pytest.param(width, height, language, marks=pytest.mark.long if width > 390 and language != "de" else ())
        for width, height in ((1280, 800), (390, 844), (844, 390))
        for language in LANGUAGES  # all on the narrowest screen, the one with the longest words on the others too
    ],
)
def test_words_of_every_language_fit_the_screen(language, width, height, tmp_path, open_page):
    """No button, tab or label is cut off, and nothing is wider than the page, whatever is opened."""
    scene = Wishes(language=language).of(scene_of([("", circling())], ideal=circling(clearance=1e-9)))
    write_page(scene, tmp_path / "p.html")
    tab = open_page((tmp_path / "p.html").as_uri(), viewport={"width": width, "height": height})
    becomes(tab, "() => window.rattle?.names.length > 0")
    for name in ("orbits", "events", "curves"):
        tab.evaluate("(name) => rattle.viewer.tabs.choose(name)", name)
        frames(tab)
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        wide = """(width) => Array.from(rattle.viewer.shadow.querySelectorAll("button, h1, summary, label, .tabs"))
          .filter((part) => part.getClientRects().length && !part.closest(".sheet"))
          .filter((part) => part.scrollWidth > part.clientWidth + 1 || part.getBoundingClientRect().right > width)
          .map((part) => part.textContent)"""
        assert tab.evaluate(wide, width) == []


def test_a_page_holds_its_own_language_alone(tmp_path):
    """An English one holds none; the title, the curves and the language reach a page of a result as well."""
    r = circling()
    r.animate(tmp_path / "fr.html", language="fr", title="L'axe", curves=["O.normal"])
    r.animate(tmp_path / "en.html")
    french, english = ((tmp_path / f"{name}.html").read_text(encoding="utf-8") for name in ("fr", "en"))
    assert '<html lang="fr">' in french
    assert '<html lang="en">' in english
    assert "<title>L&#x27;axe</title>" in french
    scene = json.loads(SCENE.search(french)[1])
    assert scene["show"]["curves"] == ["O.normal"]
    assert scene["words"] == words_in("fr")
    assert "words" not in json.loads(SCENE.search(english)[1])
    assert words_in("es")["Forces"] not in french
    assert f"<noscript>{words_in('fr')[SILENT]}</noscript>" in french


def test_runs_to_choose_from_are_labelled_in_the_language_of_the_page(tmp_path, open_page):
    runs = [("as in the model file", circling()), ("c = 1 mm", circling(clearance=0.001))]
    write_page(Wishes(language="es").of(scene_of(runs)), tmp_path / "p.html")
    tab = open_page((tmp_path / "p.html").as_uri())
    becomes(tab, "() => window.rattle?.names.length > 0")
    said = tab.evaluate("rattle.viewer.parts.runs.innerText.split(/\\s*\\n\\s*/).filter(Boolean)")
    assert said[0] == "Movimiento"
    assert {"como en el archivo del modelo", "c = 1 mm", "a trazos al lado", "nada"} <= set(said)


def test_wishes_that_cannot_be_met_are_refused_before_anything_is_written(tmp_path):
    r = circling()
    with pytest.raises(InputError, match="no language 'de-DE'; known: en, de, fr, es, zh"):
        r.animate(tmp_path / "p.html", language="de-DE")
    with pytest.raises(InputError, match=r"no curve 'O\.norml'; did you mean 'O\.normal'"):
        r.animate(tmp_path / "p.html", curves=["O.norml"])
    with pytest.raises(InputError, match="only pages"):
        r.animate(tmp_path / "p.gif", language="de")
    with pytest.raises(InputError, match="no language 'xx'"):
        rt.example("fourbar").page(tmp_path / "p.html", language="xx")
    done = CliRunner().invoke(main, ["page", "fourbar", "-o", str(tmp_path / "p.html"), "--language", "nl"])
    assert done.exit_code == 2
    assert "'en', 'de', 'fr', 'es', 'zh'" in done.stderr
    assert not list(tmp_path.iterdir())
