"""Hues that run into each other are one paint; blurred borders are borders."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

import toonkit
from toonkit import ToonImage
from toonkit.model.oklab import oklab_to_srgb

YELLOW, ORANGE, BLUE = np.array([[0.72, -0.02, 0.12], [0.62, 0.15, 0.10], [0.45, -0.03, -0.15]])
"""In OKLab: no shading leads from one of them to another."""


def block(shares: np.ndarray) -> ToonImage:
    """A square of yellow and as much orange as the shares (H, W) say, beside a blue one."""
    lab = (1 - shares[..., None]) * YELLOW + shares[..., None] * ORANGE
    lab = np.concatenate([lab, np.broadcast_to(BLUE, lab.shape)], axis=1)
    color = np.rint(np.clip(oklab_to_srgb(lab), 0, 1) * 255) / 255
    return ToonImage(color, np.ones(lab.shape[:2], bool))


def test_a_gradient_of_hues_is_one_material_that_keeps_its_paint():
    shares = np.tile(np.linspace(0, 1, 96)[:, None], (1, 96))
    image = block(shares)
    analysis = toonkit.analyze(image, (90, 45))
    materials = analysis.materials
    left = materials.labels[:, :96]
    assert materials.count == 2
    assert (left == left[0, 0]).all()
    assert materials.flat[left[0, 0]]
    relit = toonkit.relight(analysis, (0, 30)).color[4:-4, 4:90]
    painted = image.color[4:-4, 4:90]
    assert np.abs(np.diff(relit, axis=0)).max() < 0.06  # no seam where the hues were cut apart
    assert (relit <= painted + 1e-9).all()
    assert np.abs(relit / painted - (relit / painted).mean(axis=2, keepdims=True)).max() < 0.25
    assert np.array_equal(toonkit.relight(analysis, analysis.light).to_rgba(), image.to_rgba())


def test_two_paints_with_a_blurred_border_stay_two():
    sharp = np.zeros((96, 96))
    sharp[48:] = 1
    for blur in (1.0, 2.0, 3.0):
        labels = toonkit.find_materials(block(ndimage.gaussian_filter(sharp, blur))).labels
        assert len(np.unique(labels[[10, 85], 48])) == 2
