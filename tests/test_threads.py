"""An analysis is the same to the last bit on any number of cores and threads, in Python and on the command line."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import toonkit
from toonkit.export.archive import load_analysis
from toonkit.export.picture import write_picture
from toonkit.synthetic.drawing import draw_scene

SIZE = 320
"""Pixels of the drawing's width: BLAS shares sums among threads from some ten thousand numbers on."""

COMMAND = """
import os, sys
cores = sorted(os.sched_getaffinity(0))
os.sched_setaffinity(0, cores[: int(sys.argv[1])])
from toonkit.cli import main
sys.exit(main(["analyze", sys.argv[2], "-o", sys.argv[3], "--quiet"]))
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="cores can be chosen on Linux only")
def test_an_estimated_light_and_all_that_follows_do_not_depend_on_cores_and_threads(tmp_path):
    path = tmp_path / "drawing.png"
    write_picture(draw_scene(2, size=SIZE).image, path)
    expected = toonkit.analyze(path)
    assert expected.light_estimate is not None
    expected.save(tmp_path / "expected.npz")
    for cores, threads in ((1, 1), (os.cpu_count() or 1, 7)):
        folder: Path = tmp_path / f"{cores}"
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": str(threads), "OMP_NUM_THREADS": str(threads)}
        command = [sys.executable, "-c", COMMAND, str(cores), str(path), str(folder)]
        subprocess.run(command, env=environment, check=True)
        found = load_analysis(folder / "analysis.npz")
        assert found.light_estimate is not None
        assert found.light_estimate.confidence == expected.light_estimate.confidence
        assert np.array_equal(found.light, expected.light)
        assert np.array_equal(found.report.energies, expected.report.energies)
        # Archives round normals, but the energies above are those of the normals before that.
        assert (folder / "analysis.npz").read_bytes() == (tmp_path / "expected.npz").read_bytes()
