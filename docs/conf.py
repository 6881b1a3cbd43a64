"""Settings of the documentation.  Built without network; generated parts are made again at every build."""

import re
import sys
from pathlib import Path

from sphinx.errors import ExtensionError

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import making  # noqa: E402
import rattle  # noqa: E402
from making import interface  # noqa: E402

project = "rattle"
author = "rattle contributors"
project_copyright = author
version = release = rattle.__version__

extensions = ["sphinx.ext.autodoc", "myst_parser", "sphinx_design"]
exclude_patterns = ["generated/*.md", "generated/beside", "making"]  # generated/gallery holds pages of their own
smartquotes = False  # they would turn --ideal into a dash
html_theme = "pydata_sphinx_theme"
html_title = "rattle"
html_static_path = ["_static"]
html_css_files = ["rattle.css"]
(HERE / "generated" / "beside").mkdir(parents=True, exist_ok=True)
html_extra_path = ["generated/beside"]  # live/NAME.html: pages of their own, shown in frames
html_copy_source = html_show_sourcelink = False
html_theme_options = {
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_prev_next": True,
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "pygments_light_style": "default",
    "pygments_dark_style": "monokai",
}
html_sidebars = {"index": [], "first-ten-minutes": [], "gallery": [], "generated/gallery/*": []}

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3
myst_links_external_new_tab = False

autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints_format = "short"
add_module_names = False
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 118


def write_pages(app):
    """Write the generated pages before any page is read."""
    making.write_pages(HERE / "generated")


def refuse_what_is_fetched(app, error):
    """Raise if a page would fetch scripts, styles or pictures: pages must be complete without network."""
    if error is None:
        for page in Path(app.outdir).rglob("*.html"):
            text = page.read_text(encoding="utf-8")
            found = re.findall(r'<(?:script|link|img|iframe)[^>]*(?:src|href)="((?:https?:)?//[^"]*)"', text)
            if found:
                raise ExtensionError(f"{page.name} would fetch {found[0]}")


def setup(app):
    """Connect the generated pages and the reading of plain docstrings."""
    app.connect("builder-inited", write_pages)
    app.connect("build-finished", refuse_what_is_fetched)
    app.connect("autodoc-process-docstring", interface.read_docstring)
    app.connect("autodoc-process-signature", interface.shorten_signature)
    app.connect("autodoc-skip-member", interface.skip_member)
