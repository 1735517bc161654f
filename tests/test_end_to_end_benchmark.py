"""The benchmark from file to files does what the command line does, and compares it with the analysis alone."""

from __future__ import annotations

import pytest

from benchmarks import end_to_end
from toonkit import load_image


@pytest.mark.parametrize("given", [True, False])
def test_a_row_compares_what_the_command_does_with_the_analysis_in_it(given):
    row = end_to_end.measured("duck", 96, given=given, pairs=1)
    assert row["light"] == ("given" if given else "estimated")
    assert row["seconds"] == pytest.approx(row["ratio"] * row["analysis_seconds"])
    assert row["peak_bytes_per_pixel"] > 33  # the picture alone: its colors, mask and alpha
    assert row["archive_bytes_per_object_pixel"] > 2  # normals in 32 bits, compressed


def test_a_sample_is_enlarged_with_its_transparency(tmp_path):
    image = load_image(end_to_end.enlarged("duck", 600, tmp_path))
    assert image.shape == (600, 600)
    assert 0.1 < image.mask.mean() < 0.9
