"""Look into a study: a heat map of any measure, and every trial behind it.

`toonkit dashboard study FOLDER` serves the same page; with Panel's own server it is
`panel serve dashboards/study.py --address localhost --show`, with `--args FOLDER` behind that for a study of your own.
"""

from __future__ import annotations

import sys
from pathlib import Path

import panel as pn

from toonkit.viz.study_page.page import study_app

PUBLISHED = Path(__file__).parents[1] / "notebooks" / "study"

if pn.state.served:
    study_app(Path(sys.argv[1]) if len(sys.argv) > 1 else PUBLISHED).servable()
