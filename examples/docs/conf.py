"""Sphinx settings of the documentation.

python -m sphinx -W examples/docs build/docs

Before the pages are read, every Python block of every page runs, and what it prints is compared
with the block of text that follows it (`_ext/cells.py`); the figures that the blocks save are the
figures of the pages. Nothing is loaded from the network when the pages are read.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "inelastic-lorentz"
author = "The inelastic-lorentz developers"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_click",
    "cells",
    "derivation",
    "docstrings",
    "explorer",
    "formulas",
    "outputs",
    "paper_figures",
]
exclude_patterns = ["_ext", "generated/*.md"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "inelastic-lorentz"
html_static_path = ["_static"]
html_extra_path = ["generated/explorer.html"]  # which the extension of this name makes
html_css_files = ["pages.css"]
html_math_renderer = "mathml"
html_show_sourcelink = False
html_show_copyright = False
html_copy_source = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
add_module_names = False
autodoc_type_aliases = {"ArrayLike": "ArrayLike", "FloatArray": "FloatArray"}
default_role = "code"
smartquotes_action = "qe"  # not the dashes: --option is one
toc_object_entries_show_parents = "hide"
