"""Relight a drawing: drop a picture, drag the light.

`toonkit dashboard relight` serves the same page; with Panel's own server it is
`panel serve dashboards/relight.py --address localhost --show`.
"""

from __future__ import annotations

import panel as pn

from toonkit.viz.relight_page.page import relight_app

if pn.state.served:
    relight_app().servable()
