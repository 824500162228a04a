"""Sphinx's settings for the site; prepare.py lays out the pages that it reads."""

import json
import os
from pathlib import Path

from docutils import nodes
from pygments.lexer import RegexLexer
from pygments.lexers.special import TextLexer
from pygments.token import Comment, Keyword, Name, Number, String, Text

project = "Afferent"
copyright = "the authors of Afferent"
author = "the authors of Afferent"
version = release = os.environ.get("AFFERENT_VERSION", "")

extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # pages that are parts of others begin where those do
highlight_language = "none"
html_theme = "furo"
html_title = "Afferent"
html_static_path = ["_static"]
html_css_files = ["katex/katex.min.css", "site.css"]
html_js_files = [("katex/katex.min.js", {"defer": "defer"}), ("equations.js", {"defer": "defer"})]
html_show_sphinx = False
html_copy_source = False
html_math_renderer = "katex"


class SceneLexer(RegexLexer):
    tokens = {
        "root": [
            (r"#.*", Comment),
            (r'"[^"]*"', String),
            (r"[a-z_0-9]+(?= *[:{])", Name.Attribute),
            (r"[A-Za-z_][A-Za-z_0-9]*", Keyword.Constant),
            (r"-?[0-9][0-9.e-]*", Number),
            (r"[\s\S]", Text),
        ]
    }


def add_excerpts(app, page, template, context, doctree):
    if page == "search":
        app.add_js_file("page_texts.js")
        app.add_js_file("excerpts.js")


def write_page_texts(app, exception):
    if exception is None:
        texts = {page: app.env.get_doctree(page).astext() for page in sorted(app.env.found_docs)}
        Path(app.outdir, "_static", "page_texts.js").write_text(f"const pageTexts = {json.dumps(texts)};\n")


def setup(app):
    """Leaves equations to KaTeX, in the page: no network, and no TeX installed."""
    app.add_lexer("txtpb", SceneLexer)
    app.add_lexer("csv", TextLexer)
    app.connect("html-page-context", add_excerpts)
    app.connect("build-finished", write_page_texts)

    def visit(self, node, tag):
        self.body.append(self.starttag(node, tag, "", CLASS="math notranslate nohighlight"))
        self.body.append(self.encode(node.astext()) + f"</{tag}>")
        raise nodes.SkipNode

    app.add_html_math_renderer(
        "katex",
        inline_renderers=(lambda self, node: visit(self, node, "span"), None),
        block_renderers=(lambda self, node: visit(self, node, "div"), None),
    )
