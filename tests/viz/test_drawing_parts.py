"""Figures of ink, materials and their color maps."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import toonkit
from notebooks.plots.drawing_parts import color_maps, ink_layer, panels, region_colors
from toonkit import ToonAnalysis, ToonkitError
from toonkit.samples import sample_light
from toonkit.study.inked_samples import draw_sample_scene
from toonkit.study.sample_scenes import TOADSTOOL


@pytest.fixture(scope="module")
def analysis() -> ToonAnalysis:
    light = toonkit.light_direction(*sample_light("mushroom"))
    return toonkit.analyze(draw_sample_scene(TOADSTOOL, light, size=96).image, light)


def test_ink_is_dark_and_paint_is_light(analysis):
    layer, coverage = ink_layer(analysis).color, analysis.drawing.ink_coverage
    assert layer[coverage == 1].max() == 0
    assert layer[analysis.image.mask & (coverage == 0)].min() == pytest.approx(0.94)


def test_each_material_has_one_color(analysis):
    colors, labels = region_colors(analysis).color, analysis.materials.labels
    shown = [np.unique(colors[labels == number], axis=0) for number in range(analysis.materials.count)]
    assert [len(color) for color in shown] == [1] * analysis.materials.count
    assert len(np.unique(np.concatenate(shown), axis=0)) == analysis.materials.count


def test_each_material_has_its_row_of_place_tones_and_color_map(analysis):
    figure = color_maps(analysis)
    FigureCanvasAgg(figure).draw()
    assert len(figure.axes) == 3 * analysis.materials.count
    assert [axes.get_xlabel().split(",")[0] for axes in figure.axes[1::3]] == [
        "flat" if flat else "shaded" for flat in analysis.materials.flat
    ]


def test_panels_stand_under_their_titles_in_rows(analysis):
    shown = {"drawing": analysis.image, "normals": analysis.normals, "base color": analysis.base_color}
    figure = panels(shown, across=2)
    assert [axes.get_title(loc="left") for axes in figure.axes] == [*shown, ""]
    assert [len(axes.images) for axes in figure.axes] == [1, 1, 1, 0]


def test_no_panels_are_refused():
    with pytest.raises(ToonkitError, match="pictures must hold at least one"):
        panels({})
