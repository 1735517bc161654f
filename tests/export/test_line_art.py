"""The line art of a drawing is a layer that goes over its paint."""

import numpy as np

from toonkit.export.line_art import line_art


def test_line_art_over_the_paint_is_the_drawing(several):
    drawing, image = several.drawing, several.image
    layer = line_art(drawing) / 255
    paint = np.zeros((*image.shape, 3))
    paint[image.mask] = drawing.without_ink
    inside = image.mask & (image.alpha == 1)
    over = layer[..., 3:] * layer[..., :3] + (1 - layer[..., 3:]) * paint
    assert (layer[inside, 3] > 0.5).any()
    assert np.abs(over - image.color)[inside].max() < 2 / 255  # two roundings


def test_line_art_is_as_soft_at_the_silhouette_as_the_drawing(several):
    image, layer = several.image, line_art(several.drawing)
    rim = (image.alpha > 0) & (image.alpha < 1)
    assert rim.any()
    assert np.array_equal(layer[rim], image.to_rgba()[rim])


def test_where_there_is_no_ink_the_layer_is_transparent(several, analysis):
    layer = line_art(several.drawing)
    assert not layer[(several.drawing.ink_coverage == 0) & several.image.mask].any()
    assert not line_art(analysis.drawing).any()
