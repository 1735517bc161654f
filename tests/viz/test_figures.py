"""Printed figures: what an editor would send back."""

from __future__ import annotations

import itertools
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.text import Text
from matplotlib.textpath import TextPath
from matplotlib.transforms import Bbox
from skimage.color import deltaE_ciede2000, rgb2lab

import toonkit
from notebooks.plots.panels import ball, draw_picture, proportion
from notebooks.plots.paper_data import data_sets, stylized_shading
from notebooks.plots.paper_method import inflation, method_overview
from notebooks.plots.paper_reflectance import color_map_estimation, illumination_constraints
from notebooks.plots.paper_results import Comparison, relighting, shading_analysis
from toonkit import METHODS, ToonImage, ToonkitError
from toonkit.model.luminance import linear_to_srgb, srgb_to_linear
from toonkit.study.color_maps import load_color_maps, load_ramps
from toonkit.study.rendering import RenderedShape, render_shape
from toonkit.study.shapes import SHAPES
from toonkit.viz.figures.style import (
    METHOD_COLORS,
    METHOD_LABELS,
    PAGE_WIDTH,
    TEXT_SIZE,
    figure_style,
    fold,
    new_figure,
    text_width,
)

LIGHT = toonkit.light_direction(129, 50)
SIZE = 64

# Simulation of color vision without long, middle and short wavelength cones, on linear sRGB: Machado, Oliveira and
# Fernandes, IEEE Trans. Vis. Comput. Graph. 15(6), 2009, doi:10.1109/TVCG.2009.113, severity 1.
COLOR_VISION = {
    "all cones": np.eye(3),
    "no long": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "no middle": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "no short": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


@pytest.fixture(scope="module")
def pear() -> RenderedShape:
    return render_shape(SHAPES["pear"], SIZE)


def compared(truth: RenderedShape, name: str, methods=("lumo", "toonkit")) -> Comparison:
    color_map = load_color_maps()[name]
    painted = toonkit.shade(truth.normals, LIGHT, color_map)
    image = ToonImage(painted.color, painted.mask, alpha=truth.coverage)
    return Comparison(truth, color_map, [toonkit.analyze(image, LIGHT, method=method) for method in methods])


@pytest.fixture(scope="module")
def comparison(pear) -> Comparison:
    return compared(pear, "sunset")


@pytest.fixture(scope="module")
def figures(pear, comparison) -> dict[str, Figure]:
    """All eight, of small pictures."""
    maps = load_color_maps()
    image, (lumo, ours) = comparison.image, comparison.analyses
    interval = toonkit.illumination_interval(image, lumo.color_map)
    lights = [toonkit.light_direction(azimuth, 40) for azimuth in (0, 90, 270)]
    shapes = dict.fromkeys(SHAPES, pear)
    return {
        "1": stylized_shading(pear, {name: maps[name] for name in list(maps)[:6]}, LIGHT),
        "2": method_overview(ours, lights),
        "3": inflation(lumo.normals, pear, LIGHT),
        "4": color_map_estimation(image, lumo.illumination, lumo.color_map, comparison.color_map),
        "5": illumination_constraints(image, interval, lumo.illumination, ours.illumination),
        "6": data_sets(shapes, load_ramps(), LIGHT, maps["clay_smooth"]),
        "7": shading_analysis([comparison, compared(pear, "velvet")]),
        "8": relighting(comparison, lights),
    }


NUMBERS = [str(number) for number in range(1, 9)]


def drawn(figure: Figure) -> FigureCanvasAgg:
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return canvas


def texts_with_boxes(figure: Figure) -> list[tuple[str, Bbox]]:
    """What is written on a page and where, in pixels; ticks beyond an axis' ends are not written."""
    renderer = drawn(figure).get_renderer()
    hidden = set()
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            if not (axis.axes.axison and low - 1e-9 <= tick.get_loc() <= high + 1e-9):
                hidden |= {tick.label1, tick.label2}
    return [
        (text.get_text(), text.get_window_extent(renderer))
        for text in figure.findobj(Text)
        if text.get_text().strip() and text.get_visible() and text not in hidden
    ]


def texts_off_the_page(figure: Figure) -> list[str]:
    boxes = texts_with_boxes(figure)
    page = figure.bbox.padded(0.5)  # an edge may fall on half a pixel
    return [
        text
        for text, box in boxes
        if box.x0 < page.x0 or box.y0 < page.y0 or box.x1 > page.x1 or box.y1 > page.y1
    ]


def unlabeled_axes(figure: Figure) -> list[str]:
    """Axes that carry numbers but not what of."""
    drawn(figure)
    return [
        f"{side} of {axes.get_title(loc='left') or axes.get_title()!r}"
        for axes in figure.axes
        for side, axis in (("x", axes.xaxis), ("y", axes.yaxis))
        if axes.axison
        and any(label.get_visible() and label.get_text() for label in axis.get_ticklabels())
        and not axis.get_label_text()
    ]


@pytest.mark.parametrize("number", NUMBERS)
def test_no_text_leaves_the_page(figures, number):
    assert texts_off_the_page(figures[number]) == []


@pytest.mark.parametrize("number", NUMBERS)
def test_no_two_texts_overlap(figures, number):
    boxes = [(text, box.padded(-1.0)) for text, box in texts_with_boxes(figures[number])]
    pairs = itertools.combinations(boxes, 2)
    assert [(one, other) for (one, box), (other, there) in pairs if box.overlaps(there)] == []


@pytest.mark.parametrize("number", NUMBERS)
def test_every_axis_with_numbers_says_of_what(figures, number):
    assert unlabeled_axes(figures[number]) == []


@pytest.mark.parametrize("number", NUMBERS)
def test_every_figure_is_as_wide_as_a_page(figures, number):
    width, height = figures[number].get_size_inches()
    assert width == PAGE_WIDTH
    assert height < 9.5  # with its caption on one page


def test_a_title_that_is_too_long_is_found():
    with figure_style():
        figure = new_figure(1.0, width=1.0)
        figure.add_subplot(xticks=[], yticks=[]).set_title("far too long for a page that is one inch wide")
    assert len(texts_off_the_page(figure)) == 1


def test_an_axis_without_a_label_is_found():
    with figure_style():
        figure = new_figure(2.0)
        figure.add_subplot(xlabel="illumination")
    assert unlabeled_axes(figure) == ["y of ''"]


def test_the_error_maps_of_both_shapes_share_one_color_bar_in_degrees(figures):
    bars = [axes for axes in figures["7"].axes if axes.get_label() == "<colorbar>"]
    assert [axes.get_ylabel() for axes in bars] == ["angular error of the normals (degrees)"]
    assert bars[0].get_ylim() == (0.0, 60.0)


def test_every_row_of_the_shading_analysis_says_its_own_errors(figures, comparison):
    written = [text for text, _ in texts_with_boxes(figures["7"])]
    for analysis in comparison.analyses:
        angle = toonkit.angular_error(analysis.normals, comparison.truth.normals).mean
        assert f"mean {angle:.1f}°" in written
        assert f"RMSE {toonkit.color_rmse(analysis.picture, comparison.image):.3f}" in written


def test_relighting_begins_with_the_light_of_the_input(figures):
    titles = [axes.get_title() for axes in figures["8"].axes if axes.get_title()]
    assert titles[0] == "input light\n129°, 50°"
    assert len(titles) == 4


def test_the_cut_shows_the_illumination_along_its_row(figures, comparison):
    (section,) = (axes for axes in figures["5"].axes if axes.get_xlabel() == "column (pixels)")
    (refined,) = (line for line in section.lines if line.get_label() == "refined  L · N")
    rows = np.flatnonzero(comparison.image.mask.any(axis=1))
    expected = comparison.analyses[1].illumination[rows[round((len(rows) - 1) / 2)]]
    np.testing.assert_array_equal(refined.get_ydata(), expected)


@pytest.mark.parametrize("cut", [-0.1, 1.5, np.nan])
def test_a_cut_beside_the_object_is_refused(comparison, cut):
    image, analysis = comparison.image, comparison.analyses[0]
    illumination = analysis.illumination
    with pytest.raises(ToonkitError, match="cut"):
        illumination_constraints(image, analysis.intervals(), illumination, illumination, cut=cut)


def test_a_comparison_of_different_pictures_is_refused(pear, comparison):
    other = compared(pear, "moss", methods=("lumo",))
    with pytest.raises(ToonkitError, match="same picture"):
        Comparison(pear, comparison.color_map, [*comparison.analyses, *other.analyses])


def test_a_shading_analysis_of_different_methods_is_refused(pear, comparison):
    with pytest.raises(ToonkitError, match="same methods"):
        shading_analysis([comparison, compared(pear, "moss", methods=("lumo",))])


@pytest.mark.parametrize(
    "draw",
    [
        lambda truth, analysis: stylized_shading(truth, {}, LIGHT),
        lambda truth, analysis: data_sets({}, load_ramps(), LIGHT, analysis.color_map),
        lambda truth, analysis: method_overview(analysis, []),
        lambda truth, analysis: shading_analysis([]),
    ],
)
def test_a_figure_of_nothing_is_refused(pear, comparison, draw):
    with pytest.raises(ToonkitError, match="at least one"):
        draw(pear, comparison.analyses[0])


def test_a_panel_shows_the_object_from_edge_to_edge(pear):
    with figure_style():
        axes = new_figure(2.0).add_subplot()
        draw_picture(axes, ToonImage(np.zeros((*pear.mask.shape, 3)), pear.mask))
    rows, columns = np.nonzero(pear.mask)
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert left < columns.min() - 0.5 < columns.max() + 0.5 < right
    assert high < rows.min() - 0.5 < rows.max() + 0.5 < low
    assert (low - high) / (right - left) == pytest.approx(proportion(pear.normals))


def test_the_ball_of_a_light_is_brightest_where_the_light_stands():
    normals, coverage = ball(101)
    light = toonkit.light_direction(129, 50)
    row, column = np.unravel_index(np.nanargmax(toonkit.illumination(normals, light)), normals.shape)
    assert (column - 50) / 49.5 == pytest.approx(light[0], abs=0.02)
    assert (50 - row) / 49.5 == pytest.approx(light[1], abs=0.02)
    np.testing.assert_array_equal(normals.mask, coverage >= 0.5)


def test_every_method_has_a_color_and_a_name():
    assert {*METHODS, "flat"} <= set(METHOD_COLORS)
    assert set(METHOD_COLORS) <= set(METHOD_LABELS)


@pytest.mark.parametrize("vision", COLOR_VISION)
def test_colors_of_methods_stay_apart_for_color_blind_readers(vision):
    linear = srgb_to_linear([to_rgb(color) for color in METHOD_COLORS.values()])
    seen = linear_to_srgb(np.clip(linear @ np.transpose(COLOR_VISION[vision]), 0, 1))
    lab = rgb2lab(np.clip(seen, 0, 1))
    differences = [deltaE_ciede2000(one, other) for one, other in itertools.combinations(lab, 2)]
    assert min(differences) > 15  # just noticeable differences are about 1


def test_a_figure_is_drawn_in_a_font_of_matplotlib_whatever_the_machine_and_the_user_have():
    with mpl.rc_context({"font.family": "fantasy", "font.weight": "bold", "axes.unicode_minus": False}):
        with figure_style():
            figure = new_figure(1.0)
            text = figure.text(0.5, 0.5, "light · normal")
        properties = text.get_fontproperties()
        assert properties.get_weight() == "normal"
        assert Path(findfont(properties)).is_relative_to(mpl.get_data_path())


@pytest.mark.parametrize("font", ["DejaVu Sans", "DejaVu Sans Mono", "DejaVu Serif", "STIXGeneral"])
@pytest.mark.parametrize("width", [0.8, 1.0, 2.0])
def test_a_folded_text_keeps_its_words_and_fits_its_width_in_every_font_of_matplotlib(width, font):
    text = "mean width of the steps between tones"
    folded = fold(text, width)
    assert folded.split() == text.split()
    drawn = max(folded.split("\n"), key=len)
    measured = TextPath((0, 0), drawn, TEXT_SIZE, prop=FontProperties(font)).get_extents().width / 72
    assert measured <= text_width(folded) <= width


def test_a_figure_leaves_the_style_of_others_alone():
    before = dict(mpl.rcParams)
    with figure_style():
        new_figure(1.0)
    assert dict(mpl.rcParams) == before
