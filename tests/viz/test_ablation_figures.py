"""The figures of parts and of lights show what their tables hold, and nothing is cut off."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex

import toonkit
from notebooks.plots.ablation import ORACLES, ablation_table, draw_ablation, draw_stages
from notebooks.plots.light_errors import draw_light_errors, light_errors
from notebooks.plots.paper_results import Comparison
from tests.viz.test_study_figures import FONTS, texts_off_the_page
from toonkit import Materials, ToonkitError
from toonkit.study.color_maps import load_color_maps
from toonkit.study.rendering import render_shape
from toonkit.study.shapes import SHAPES
from toonkit.viz.figures import style
from toonkit.viz.figures.style import METHOD_COLORS

LIGHT = toonkit.light_direction(129, 50)
FACTORS = {"todo": 1.0, "classical": 0.8, "learned shape alone": 0.75, "toonkit": 0.65, ORACLES[0]: 0.5}


def parts(shapes: int = 6, color_maps: int = 6) -> pd.DataFrame:
    """A table in which a variant's errors are a shape's own times a factor."""
    difficulty = np.random.default_rng(3).uniform(0.7, 1.4, shapes)
    return pd.DataFrame(
        [
            {
                "variant": variant,
                "shape": name,
                "color_map": f"map_{place}",
                "size": 64,
                "angular_error": 20.0 * factor * difficulty[row],
                "relight_rmse": 0.1 * factor * difficulty[row],
                "input_rmse": 0.02 * factor,
                "seconds": 0.5,
            }
            for variant, factor in FACTORS.items()
            for row, name in enumerate(list(SHAPES)[:shapes])
            for place in range(color_maps)
        ]
    )


def estimates(shapes: int = 10, pictures: int = 200) -> pd.DataFrame:
    """Lights whose errors are as likely below 10 degrees as their confidence says."""
    generator = np.random.default_rng(5)
    confidence = generator.uniform(0.05, 0.95, shapes * pictures)
    close = generator.uniform(size=confidence.size) < confidence
    return pd.DataFrame(
        {
            "shape": np.repeat(list(SHAPES)[:shapes], pictures),
            "elevation": np.tile([20.0, 47.5, 75.0, 75.0], confidence.size // 4),
            "error": np.where(
                close, generator.uniform(0, 10, close.size), generator.uniform(10, 90, close.size)
            ),
            "confidence": confidence,
        }
    )


def drawn(figure):
    FigureCanvasAgg(figure).draw()
    return figure


@pytest.fixture(scope="module")
def stages():
    color_map = load_color_maps()["terracotta"]
    truth = render_shape(SHAPES["pear"], 64)
    painted = toonkit.shade(truth.normals, LIGHT, color_map)
    image = toonkit.ToonImage(painted.color, painted.mask, alpha=truth.coverage)
    named = {"first": toonkit.inflate(image.mask, alpha=image.alpha), "last": truth.normals}
    return Comparison(
        truth,
        color_map,
        [
            toonkit.ToonAnalysis(
                image, name, LIGHT, normals, normals, Materials.single(image.mask, color_map)
            )
            for name, normals in named.items()
        ],
    )


FIGURES = {
    "against the paper": lambda _: draw_ablation(parts()),
    "against toonkit": lambda _: draw_ablation(
        parts(), ("angular_error", "relight_rmse", "input_rmse"), versus="toonkit"
    ),
    "of a single picture": lambda _: draw_ablation(parts(1, 1)),
    "lights": lambda _: draw_light_errors(estimates()),
    "lights of few shapes": lambda _: draw_light_errors(estimates(2, 8)),
    "lights all equally sure": lambda _: draw_light_errors(estimates().assign(confidence=0.5)),
    "stages": lambda stages: draw_stages(stages, toonkit.light_direction(20, 35)),
}


@pytest.mark.parametrize("font", FONTS)
@pytest.mark.parametrize("name", FIGURES)
def test_no_text_leaves_the_page(stages, name, font, monkeypatch):
    monkeypatch.setattr(style, "FONT", font)
    assert texts_off_the_page(drawn(FIGURES[name](stages))) == []


@pytest.mark.parametrize("name", [name for name in FIGURES if name != "stages"])
def test_every_panel_says_what_it_shows(stages, name):
    figure = FIGURES[name](stages)
    assert all(axes.get_title() and axes.get_xlabel() for axes in figure.axes)


def dots(axes):
    """Places of the dots, row by row."""
    return [float(line.get_xdata()[0]) for line in axes.lines if line.get_marker() == "o"]


def test_dots_stand_at_the_mean_differences_from_the_compared_variant():
    table = parts()
    means = table.groupby("variant", sort=False)["angular_error"].mean()
    axes = draw_ablation(table).axes[0]
    assert dots(axes) == pytest.approx((means - means["todo"]).tolist())
    shown = [text.get_text() for text in axes.texts]
    assert shown == [f"{mean:.1f}°" for mean in means]


def test_the_interval_lies_around_its_dot():
    axes = draw_ablation(parts()).axes[0]
    bars = {
        float(line.get_ydata()[0]): line.get_xdata()
        for line in axes.lines
        if line.get_marker() == "None" and len(set(line.get_ydata())) == 1
    }
    for row, place in enumerate(dots(axes)):
        if row:  # the compared variant has none
            low, high = bars[row]
            assert low < place < high


def test_an_oracle_is_hollow_and_nothing_else_is():
    axes = draw_ablation(parts()).axes[0]
    faces = [to_hex(line.get_markerfacecolor()) for line in axes.lines if line.get_marker() == "o"]
    assert [face == "#ffffff" for face in faces] == [name in ORACLES for name in FACTORS]
    assert faces[3] == METHOD_COLORS["toonkit"]


@pytest.mark.parametrize(("shapes", "few"), [(4, True), (5, False)])
def test_of_few_shapes_there_is_no_interval_and_the_figure_says_so(shapes, few):
    figure = draw_ablation(parts(shapes, 6))
    assert ("too few for an interval" in " ".join(figure.get_supxlabel().split())) == few


@pytest.mark.parametrize("draw", [draw_ablation, ablation_table])
def test_a_variant_that_is_not_there_is_refused(draw):
    with pytest.raises(ToonkitError, match="versus must be one of todo"):
        draw(parts(), versus="lumo")


def test_what_is_worse_than_toonkit_has_a_plus_in_the_table():
    table = ablation_table(parts())
    column = table["normals, from toonkit"]
    assert column["Todo & Yamaguchi"].startswith("+")
    assert column[ORACLES[0]].startswith("−")
    assert column["toonkit"] == ""
    assert table.loc["toonkit", "input, RMSE (sRGB)"] == "0.013"


def test_estimates_that_are_right_as_often_as_they_say_lie_on_the_diagonal():
    axes = draw_light_errors(estimates()).axes[2]
    places = np.array([line.get_xydata()[0] for line in axes.lines if line.get_marker() == "o"])
    assert len(places) == 10
    assert (
        np.abs(places[:, 0] - places[:, 1]).max() < 0.1
    )  # a tenth is 200 pictures: their share is sure to 0.035


def test_estimates_that_are_too_sure_lie_below_the_diagonal():
    boasting = estimates()
    boasting["confidence"] = np.sqrt(boasting["confidence"])
    axes = draw_light_errors(boasting).axes[2]
    places = np.array([line.get_xydata()[0] for line in axes.lines if line.get_marker() == "o"])
    assert (places[:-1, 1] < places[:-1, 0]).all()


def test_medians_by_elevation_are_those_of_the_table():
    table = estimates()
    axes = draw_light_errors(table).axes[1]
    middles = [float(line.get_ydata()[0]) for line in axes.lines if line.get_marker() == "o"]
    assert middles == pytest.approx(table.groupby("elevation")["error"].median().tolist())
    assert [text.get_text() for text in axes.get_xticklabels()] == ["20°", "47.5°", "75°"]


def test_errors_are_summed_up_for_the_surer_half_the_rest_and_each_elevation():
    table = pd.DataFrame(
        {"elevation": [20, 20, 75, 75], "error": [2.0, 30.0, 4.0, 20.0], "confidence": [0.9, 0.2, 0.8, 0.1]}
    )
    summary = light_errors(table)
    assert summary["mean error (°)"].to_dict() == {
        "all pictures": 14.0,
        "the surer half": 3.0,
        "the rest": 25.0,
        "elevation 20°": 16.0,
        "elevation 75°": 12.0,
    }
    assert summary.loc["the surer half", "share within 10°"] == 1.0
    assert summary["pictures"].tolist() == [4, 2, 2, 2, 2]


def test_the_surer_half_is_a_half_even_if_all_are_equally_sure():
    table = estimates().assign(confidence=0.5)
    assert light_errors(table).loc["the surer half", "pictures"] == len(table) / 2


def test_each_stage_says_how_wrong_it_is(stages):
    figure = drawn(draw_stages(stages, toonkit.light_direction(20, 35)))
    captions = [axes.get_xlabel() for axes in figure.axes if axes.get_xlabel()]
    error = toonkit.angular_error(stages.analyses[0].normals, stages.truth.normals).mean
    assert f"mean {error:.1f}°" in captions
    assert "mean 0.0°" in captions  # the last stage is the truth
    assert "RMSE 0.000" in captions
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert titles == ["input", "first", "last", "truth"]
