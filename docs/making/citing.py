"""How to cite, from CITATION.cff."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from making.text import fence, paragraph
from making.tree import ROOT


def pages(folder: Path) -> dict[str, str]:
    """The citation as a sentence and for BibTeX."""
    said: dict[str, Any] = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    authors = [_name(one) for one in said["authors"]]
    year = str(said.get("date-released", ""))[:4]
    dated = f" ({year})" if year else ""
    sentence = f"{', '.join(authors)}{dated}. *{paragraph(said['title'])}*, version {said['version']}."
    lines = {"author": " and ".join(f"{{{one}}}" for one in authors), "title": f"{{{said['title']}}}"}
    lines |= {"version": said["version"]} | ({"year": year} if year else {})
    entry = ["@software{rattle,", *(f"  {key} = {{{value}}}," for key, value in lines.items()), "}"]
    return {"citing": sentence + "\n\n" + fence("\n".join(entry), "bibtex") + "\n"}


def _name(author: dict[str, str]) -> str:
    return author.get("name") or f"{author['given-names']} {author['family-names']}"
