"""What an object says of itself: one line anywhere, a small picture in a notebook."""

from io import BytesIO
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient
from PIL import Image

import toonkit
from tests.analytic import LIGHT, SOFT, ellipse, painted
from toonkit.model.description import LONGEST_SIDE
from toonkit.model.label_colors import label_picture


@pytest.fixture(scope="module")
def analysis():
    """An egg in two materials."""
    egg = ellipse(40, 24)
    image = painted(egg.normals, SOFT, alpha=egg.coverage)
    labels = (egg.x > 0).astype(int)
    return toonkit.analyze(image, LIGHT, materials=labels)


def decoded(shown):
    with Image.open(BytesIO(shown._repr_png_())) as picture:
        assert picture.format == "PNG"
        return np.asarray(picture)


def test_every_line_says_what_a_thing_is(analysis):
    rows, columns = analysis.image.shape
    size = f"{columns} x {rows} pixels, object covers {100 * analysis.image.mask.mean():.0f} %"
    height = toonkit.height_map(analysis.normals)
    assert repr(analysis.image) == f"ToonImage({size})"
    assert repr(analysis.normals) == f"NormalField({size})"
    assert repr(analysis.drawing) == f"PreparedDrawing({size})"
    assert repr(analysis.materials) == f"Materials(2 materials, 0 flat, {size})"
    assert repr(height) == f"HeightField({size}, 0 to {np.nanmax(height.height):.1f} pixels high)"
    assert repr(analysis) == (
        f"ToonAnalysis(method 'toonkit', {size}, 2 materials, light at azimuth 130°, elevation 50° (given))"
    )


@pytest.mark.parametrize(
    ("thing", "line"),
    [
        (
            toonkit.ColorMap([[0, 0, 0], [1, 1, 1]], (-0.5, 1)),
            "ColorMap(2 samples, #000000 to #ffffff, illumination -0.50 to 1.00)",
        ),
        (
            toonkit.LightEstimate(toonkit.light_direction(-30, 50), 0.625),
            "LightEstimate(azimuth 330°, elevation 50°, confidence 0.62)",
        ),
        (
            toonkit.SolverReport(1, np.array([4.0, 1.0]), "nothing left", converged=True),
            "SolverReport(1 iteration, converged, energy 4 to 1: nothing left)",
        ),
        (
            toonkit.SolverReport(7, np.zeros(0), "out of time", converged=False),
            "SolverReport(7 iterations, not converged: out of time)",
        ),
        (
            toonkit.ErrorSummary(np.zeros((2, 2)), 1.25, 1.0, 3.0, 0.5),
            "ErrorSummary(mean 1.25, median 1, 95th percentile 3, mean without rim 0.5)",
        ),
        (
            toonkit.IlluminationInterval([[0.0, np.nan]], [[0.5, np.nan]]),
            "IlluminationInterval(shape (1, 2), mean width 0.50)",
        ),
        (toonkit.IlluminationInterval([np.nan], [np.nan]), "IlluminationInterval(shape (1,))"),
    ],
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else "",
)
def test_a_line_holds_the_numbers(thing, line):
    assert repr(thing) == line


def test_an_estimated_light_comes_with_its_confidence(analysis):
    found = toonkit.analyze(analysis.image, method="lumo")
    assert repr(found).endswith(f"(estimated, confidence {found.light_estimate.confidence:.2f}))")


def test_materials_without_color_maps_say_so(analysis):
    assert repr(toonkit.find_materials(analysis.image)).endswith(", without color maps)")


def test_a_picture_is_shown_as_it_is(analysis):
    assert np.array_equal(decoded(analysis.image), analysis.image.to_rgba())


def test_normals_are_shown_as_a_normal_map_on_a_transparent_ground(analysis):
    shown, mask = decoded(analysis.normals), analysis.normals.mask
    assert np.array_equal(shown[..., 3], np.where(mask, 255, 0))
    vectors = shown[mask][:, :3] / 127.5 - 1
    assert np.abs(vectors - analysis.normals.compact).max() <= 0.5 / 127.5 + 1e-12  # half a step of 8 bits


def test_materials_are_shown_as_regions_of_one_color_each(analysis):
    assert np.array_equal(decoded(analysis.materials), label_picture(analysis.materials.labels))


def test_a_color_map_is_shown_from_dark_to_bright():
    shown = decoded(toonkit.ColorMap([[0.2, 0, 0], [1, 0.8, 0.6]], (-1, 1)))
    assert shown.shape == (32, 512, 3)
    assert shown[0, 0].tolist() == [51, 0, 0]
    assert shown[-1, -1].tolist() == [255, 204, 153]


def test_a_large_picture_is_reduced():
    labels = np.zeros((300, 2 * LONGEST_SIDE), int)
    labels[:, LONGEST_SIDE:] = 1
    image = toonkit.ToonImage(np.where(labels[..., None], 0.25, 0.75) * np.ones(3), labels >= 0)
    materials = toonkit.Materials(labels, (np.ones((1, 3)),) * 2, np.zeros(2, bool))
    assert decoded(image).shape == (150, LONGEST_SIDE, 4)
    assert decoded(materials).shape == (150, LONGEST_SIDE, 4)
    assert len(np.unique(decoded(materials).reshape(-1, 4), axis=0)) == 2  # no color between two materials


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the kernel's own libraries, while they connect
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # sockets that zmq closes late
def test_a_notebook_shows_pictures(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(toonkit.__file__).parents[1]))
    cells = [
        (
            "import numpy as np, toonkit\n"
            "normals = toonkit.inflate(np.hypot(*np.mgrid[-20:21, -20:21]) < 18)\n"
            "ramp = toonkit.ColorMap([[0.2, 0.1, 0.3], [1, 0.9, 0.7]])\n"
            "toonkit.shade(normals, (135, 45), ramp)"
        ),
        "normals",
        "ramp",
        "toonkit.Materials.single(normals.mask, ramp)",
    ]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    shown = [cell.outputs[0]["data"] for cell in notebook.cells]
    assert [data["text/plain"].partition("(")[0] for data in shown] == [
        "ToonImage",
        "NormalField",
        "ColorMap",
        "Materials",
    ]
    assert all(data["image/png"] for data in shown)
