"""Settings of Sphinx for the site."""

import html
import pkgutil
import textwrap
from pathlib import Path

import yaml
from docutils import nodes
from sphinx.util.nodes import make_refnode

import study
from docs.docstrings import restructured

_CITED = yaml.safe_load((Path(__file__).parent.parent / "CITATION.cff").read_text(encoding="utf-8"))

project = "Time integration schemes"
html_title = "Time integration schemes on non-linear dynamic equations"
author = copyright = ", ".join(
    one.get("name") or f"{one['given-names']} {one['family-names']}" for one in _CITED["authors"]
)
version = release = study.__version__
language = "en"
extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc"]
exclude_patterns = ["included/*"]
nitpicky = True

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
numpydoc_show_class_members = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"

html_theme = "furo"
html_static_path = [str(Path(__file__).parent / "static")]
html_css_files = ["site.css"]
html_js_files = [("table.js", {"defer": "defer"})]
html_copy_source = html_show_sourcelink = False
# the same pages on any day
html_last_updated_fmt = None
pygments_style, pygments_dark_style = "friendly", "monokai"


def _resolve(app, env, node, contnode):
    """A name of the code that the site does not document under this path: its public name, or plain text.

    A name that does not exist stays a warning.
    """
    target = node.get("reftarget", "")
    if node.get("refdomain") != "py" or target.endswith("."):
        return None
    name = target.rpartition(".")[2]
    documented = env.domains["py"].objects.get(f"study.{name}")
    if documented and target != f"study.{name}":
        return make_refnode(app.builder, node["refdoc"], documented.docname, documented.node_id, contnode)
    try:
        pkgutil.resolve_name(target)
    except (AttributeError, ImportError, ValueError):
        return None
    return contnode


def _docstring(app, what, name, documented, options, lines):
    lines[:] = restructured(lines)


def _describe(app, pagename, templatename, context, doctree):
    """A page that does not describe itself is described by its first paragraph, which searches show."""
    if doctree is not None and 'name="description"' not in context["metatags"]:
        said = next((paragraph.astext() for paragraph in doctree.findall(nodes.paragraph)), "")
        text = html.escape(textwrap.shorten(said, 160, placeholder=" …"))
        context["metatags"] += f'<meta name="description" content="{text}">'


def setup(app):
    """Change docstrings before numpydoc reads them, resolve names that are no page's own, and describe pages."""
    app.connect("html-page-context", _describe)
    app.connect("missing-reference", _resolve)
    app.connect("autodoc-process-docstring", _docstring, priority=400)
