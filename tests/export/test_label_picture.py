"""Materials become pictures, and pictures materials."""

import numpy as np
import pytest
from PIL import Image

from toonkit import ToonkitError
from toonkit.export.label_picture import MOST_LABELS, read_labels
from toonkit.export.picture import write_picture
from toonkit.model.label_colors import label_picture
from toonkit.model.oklab import srgb_to_oklab

BLOCKS = np.kron([[0, 0, 0], [1, 1, -1], [2, 2, -1]], np.ones((4, 4), int))
"""Three labels, the largest first, and nothing in a corner."""


def test_successive_labels_have_colors_far_apart():
    colors = label_picture(np.arange(20)[None])[0, :, :3]
    lab = srgb_to_oklab(colors / 255)
    apart = np.linalg.norm(lab[:, None] - lab, axis=-1) + np.eye(20)
    assert apart.min() > 0.05  # more than twice what the eye tells apart side by side
    assert np.diagonal(apart, 1).min() > 0.2


def test_every_label_that_may_be_read_has_a_color_of_its_own():
    colors = label_picture(np.arange(MOST_LABELS)[None])[0]
    assert len(np.unique(colors, axis=0)) == MOST_LABELS


def test_a_label_has_one_color_however_many_there_are():
    assert np.array_equal(label_picture(np.array([[0, 1]])), label_picture(np.array([[0, 1, 2]]))[:, :2])


def test_where_there_is_no_label_a_picture_is_transparent():
    assert np.array_equal(label_picture(BLOCKS)[..., 3], np.where(BLOCKS < 0, 0, 255))


@pytest.mark.parametrize("suffix", [".png", ".webp"])
def test_labels_are_read_back(tmp_path, suffix):
    write_picture(label_picture(BLOCKS), tmp_path / f"labels{suffix}")
    assert np.array_equal(read_labels(tmp_path / f"labels{suffix}"), BLOCKS)


def test_every_color_is_a_label_however_close_to_another(tmp_path):
    colors = np.array([[250, 250, 250], [0, 0, 0], [250, 250, 251]], np.uint8)
    write_picture(colors[np.maximum(BLOCKS, 0)], tmp_path / "labels.png")
    assert np.array_equal(read_labels(tmp_path / "labels.png"), np.maximum(BLOCKS, 0))


def test_every_index_of_a_palette_is_a_label_whatever_its_color(tmp_path):
    picture = Image.fromarray(np.where(BLOCKS < 0, 9, BLOCKS).astype(np.uint8))
    picture.putpalette([40, 40, 40] * 256)
    picture.save(tmp_path / "labels.png", transparency=9)
    assert np.array_equal(read_labels(tmp_path / "labels.png"), BLOCKS)


def test_what_is_less_than_half_opaque_is_unknown(tmp_path):
    pixels = label_picture(np.abs(BLOCKS))
    pixels[..., 3] = np.where(BLOCKS < 0, 127, 128)
    write_picture(pixels, tmp_path / "labels.png")
    assert np.array_equal(read_labels(tmp_path / "labels.png") < 0, BLOCKS < 0)


@pytest.mark.parametrize(
    ("name", "pixels", "reason"),
    [
        ("labels.jpg", np.zeros((4, 4, 3)), r"end in \.png or \.webp"),
        ("labels.png", np.zeros((4, 4, 4)), "be opaque .* transparent everywhere"),
        (
            "labels.png",
            np.dstack([*np.indices((17, 17)), np.zeros((17, 17))]),
            "have at most 256 colors, .* with 289 colors",
        ),
    ],
)
def test_what_names_no_materials_is_refused(tmp_path, name, pixels, reason):
    Image.fromarray(pixels.astype(np.uint8)).save(tmp_path / name)
    with pytest.raises(ToonkitError, match=f"materials must {reason}"):
        read_labels(tmp_path / name)


def test_a_missing_picture_is_refused(tmp_path):
    with pytest.raises(ToonkitError, match="materials must be an existing file"):
        read_labels(tmp_path / "nowhere.png")


def test_damaged_metadata_and_color_spaces_do_not_change_labels(tmp_path):
    indexed = Image.fromarray(np.repeat(np.arange(2, dtype=np.uint8), 32).reshape(8, 8))
    indexed.putpalette([255, 0, 0, 0, 255, 0] + [0] * 762)
    indexed.save(tmp_path / "labels.png", exif=b"Exif\0\0no metadata", icc_profile=b"no profile")
    labels = read_labels(tmp_path / "labels.png")
    assert (labels == np.asarray(indexed)).all()
