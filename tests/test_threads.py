"""An analysis is the same to the last bit on any number of cores and threads, in Python, as a command and on the page."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import toonkit
from toonkit.export.archive import load_analysis
from toonkit.export.picture import write_picture
from toonkit.synthetic.drawing import draw_scene

SIZE = 320
"""Pixels of the drawing's width: BLAS shares sums among threads from some ten thousand numbers on."""

ON_SOME_CORES = """
import os, sys
cores = sorted(os.sched_getaffinity(0))
os.sched_setaffinity(0, cores[: int(sys.argv[1])])
drawing, folder = sys.argv[2:]
"""

WAYS = {
    "python": """
import toonkit
toonkit.analyze(drawing).save(folder + "/analysis.npz")
""",
    "command": """
from toonkit.cli import main
main(["analyze", drawing, "-o", folder, "--quiet"])
""",
    "dashboard": """
import asyncio
from pathlib import Path
from toonkit.viz.relight_page.state import RelightState
state = RelightState()
asyncio.run(state.open_file("drawing.png", Path(drawing).read_bytes()))
state.analysis.save(folder + "/analysis.npz")
""",
}
"""Programs that analyze a drawing and estimate its light."""


@pytest.fixture(scope="module")
def drawing(tmp_path_factory):
    path = tmp_path_factory.mktemp("drawing") / "drawing.png"
    write_picture(draw_scene(2, size=SIZE).image, path)
    return path


@pytest.fixture(scope="module")
def expected(drawing):
    """The archive that is made in this process."""
    path = drawing.with_name("expected.npz")
    toonkit.analyze(drawing).save(path)
    return path


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores can be chosen on Linux only")
@pytest.mark.parametrize(
    ("way", "cores", "threads"), [("python", 1, 1), ("command", 1, 1), ("command", 2, 7), ("dashboard", 2, 7)]
)
def test_an_estimated_light_and_all_that_follows_do_not_depend_on_way_cores_and_threads(
    way, cores, threads, drawing, expected, tmp_path
):
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": str(threads), "OMP_NUM_THREADS": str(threads)}
    command = [sys.executable, "-c", ON_SOME_CORES + WAYS[way], str(cores), str(drawing), str(tmp_path)]
    subprocess.run(command, env=environment, check=True)
    mine, other = load_analysis(expected), load_analysis(tmp_path / "analysis.npz")
    assert mine.light_estimate is not None
    assert other.light_estimate is not None
    assert other.light_estimate.confidence == mine.light_estimate.confidence
    assert np.array_equal(other.light, mine.light)
    assert np.array_equal(other.report.energies, mine.report.energies)
    # Archives round normals, but the energies above are those of the normals before that.
    assert (tmp_path / "analysis.npz").read_bytes() == expected.read_bytes()
