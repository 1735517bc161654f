"""Settings of the documentation site: `python -m sphinx -W -c docs . build/site` builds it from the root."""

from __future__ import annotations

from pathlib import Path

from toonkit import __version__

project = "toonkit"
author = "The toonkit authors"
project_copyright = "The toonkit authors"
release = version = __version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "myst_nb",
]

# The source folder is the root of the repository, so that a link between README, docs/ and notebooks/ is the same
# here and on GitHub.
root_doc = "docs/index"
templates_path = [str(Path(__file__).parent / "templates")]  # autosummary takes relative ones from the root
include_patterns = ["*.md", "docs/**.md", "docs/api/*.rst", "notebooks/*.ipynb"]
exclude_patterns = [".*", "build", "dist", "study", "training", "**/.ipynb_checkpoints"]
suppress_warnings = [
    "config.cache",
    "mystnb.unknown_mime_type",  # HoloViews' own, beside the HTML that is shown
]

# Notebooks are committed without output. -D nb_execution_mode=force runs them.
nb_execution_mode = "off"
nb_execution_timeout = 600
nb_output_stderr = "remove"

myst_enable_extensions = ["html_image", "dollarmath"]
myst_heading_anchors = 3

autosummary_generate = True
autosummary_imported_members = True
autodoc_typehints = "none"
autodoc_member_order = "groupwise"
napoleon_google_docstring = False
napoleon_use_ivar = True  # attributes are listed with their class, not documented once more

html_theme = "pydata_sphinx_theme"
html_title = f"toonkit {release}"
html_extra_path = ["extra"]
html_show_sourcelink = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "footer_start": ["copyright"],
    "footer_end": [],
}
