"""The color maps of a drawing on the page, without a browser."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import panel as pn

from toonkit.model.luminance import tone
from toonkit.viz.choice_cards import ChoiceCards
from toonkit.viz.relight_page.color_maps import ColorMapsView


def shown(view):
    """The parts of a view by their type, and the tones of the curve that its plot shows."""
    panes = view.__panel__()
    return panes, list(panes.select(ChoiceCards)), list(panes.select(pn.pane.HoloViews))


def test_a_drawing_in_one_material_has_no_list(ball):
    _, cards, plots = shown(ColorMapsView(ball, height=380))
    assert cards == []
    assert len(plots) == 1


def test_materials_are_listed_by_their_area_with_share_and_kind(harlequin):
    _, (cards,), plots = shown(ColorMapsView(harlequin, height=380))
    percents = [int(choice["title"].split()[0]) for choice in cards.choices]
    assert percents == sorted(percents, reverse=True)
    assert sum(percents) in (99, 100, 101)
    assert [choice["text"] for choice in cards.choices] == ["", "", "flat"]
    assert cards.value == "0"
    assert len(plots) == 2


def test_a_chosen_material_is_put_on_screen(harlequin):
    view = ColorMapsView(harlequin, height=380)
    _, (cards,), (_, fit) = shown(view)

    async def choose():
        cards.value = "2"
        while "derived" not in view._note.object:
            await asyncio.sleep(0.02)

    with ThreadPoolExecutor(max_workers=1) as pool:
        pool.submit(asyncio.run, asyncio.wait_for(choose(), 30)).result()
    curve = fit.object[()].Curve.I
    where = curve.dimension_values("illumination")
    np.testing.assert_allclose(curve.dimension_values("tone"), tone(harlequin.materials.color_maps[2](where)))
