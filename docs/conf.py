"""How the documentation is built: `make docs`, then docs/_build/index.html."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

import gough  # noqa: E402

project, author, release = "gough", "the authors of gough", gough.__version__
copyright = "the authors of gough; Apache-2.0"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
extensions += ["executed", "pictures"]  # docs/_ext
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = "gough"
html_static_path = ["_static"]
html_css_files = ["own.css"]
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]
napoleon_numpy_docstring = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"
nitpicky = False


def setup(app):
    from pygments.lexers.gcodelexer import GcodeLexer

    app.add_lexer("ngc", GcodeLexer)
