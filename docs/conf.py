"""Settings of Sphinx for the site."""

import html
import textwrap
from pathlib import Path

import yaml
from docutils import nodes

import study
from docs.docstrings import restructured

_CITED = yaml.safe_load((Path(__file__).parent.parent / "CITATION.cff").read_text(encoding="utf-8"))

project = "Time integration schemes"
html_title = "Time integration schemes on non-linear dynamic equations"
author = copyright = ", ".join(
    person.get("name") or f"{person['given-names']} {person['family-names']}" for person in _CITED["authors"]
)
version = release = study.__version__
language = "en"
extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_copybutton",
    "docs.executed",
    "docs.mathml",
]
exclude_patterns = ["included/*"]
nitpicky = True
# references not checked: to other packages, whose documentation is missing during the build, and to private modules
nitpick_ignore_regex = [("py:.*", r"(jax|numpy|scipy|xarray|study\.(?!building|materials|settings)[a-z]\w*)\..*")]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
# a line of text that begins with a percent sign is not a comment
myst_disable_syntax = ["myst_line_comment"]
myst_heading_anchors = 3
numpydoc_show_class_members = False
autodoc_default_options = {"members": True}
autodoc_typehints = "none"
autodoc_member_order = "bysource"

# no copy button on the output of code
copybutton_selector = "div:not(.highlight-text) > div.highlight > pre"

html_theme = "furo"
html_math_renderer = "mathml"
html_static_path = [str(Path(__file__).parent / "static")]
html_css_files = ["site.css"]
html_js_files = [(name, {"defer": "defer"}) for name in ("table.js", "scroll.js", "answers.js")]
html_copy_source = html_show_sourcelink = False
# no date of the build, so that equal data give equal pages
html_last_updated_fmt = None
pygments_style, pygments_dark_style = "a11y-high-contrast-light", "a11y-high-contrast-dark"


def _docstring(app, what, name, documented, options, lines):
    lines[:] = restructured(lines)


def _describe(app, pagename, templatename, context, doctree):
    """Use the first paragraph as description for search engines, if a page declares no description."""
    if doctree is not None and 'name="description"' not in context["metatags"]:
        summary = next((paragraph.astext() for paragraph in doctree.findall(nodes.paragraph)), "")
        text = html.escape(textwrap.shorten(summary, 160, placeholder=" …"))
        context["metatags"] += f'<meta name="description" content="{text}">'


def setup(app):
    """Register two handlers: one changes docstrings before numpydoc reads them, one adds descriptions to pages."""
    app.connect("html-page-context", _describe)
    app.connect("autodoc-process-docstring", _docstring, priority=400)
