"""Whatever comes in, toonkit answers with finite numbers, unit normals and colors in [0, 1], or raises ToonkitError."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

import toonkit
from tests.analytic import ellipse
from tests.fuzz.profiles import fuzz
from toonkit import ColorMap, IlluminationInterval, RefinementOptions, ToonAnalysis, ToonImage, ToonkitError
from toonkit.export.archive import load_analysis, save_analysis
from toonkit.export.color_map import read_color_map, write_color_map
from toonkit.study.painting import StudySettings
from toonkit.study.record_store import RecordStore
from toonkit.study.records import Trial, blank_record

SHAPE = ellipse(9, 7)
RAMP = ColorMap([[0.2, 0.1, 0.3], [0.6, 0.4, 0.4], [0.9, 0.8, 0.6]])
PICTURE = toonkit.shade(SHAPE.normals, toonkit.light_direction(135, 45), RAMP)
FORMATS = ("PNG", "JPEG", "TIFF", "GIF", "WEBP")
LONGEST = 64


def refusals() -> suppress:
    """Let refusals pass; a test that fails met another error, a warning, or an answer that is none."""
    return suppress(ToonkitError)


def check_picture(picture: ToonImage) -> None:
    inside = picture.color[picture.mask]
    assert np.isfinite(inside).all()
    assert inside.min() >= 0
    assert inside.max() <= 1
    assert picture.alpha.min() >= 0
    assert picture.alpha.max() <= 1


def check_analysis(analysis: ToonAnalysis) -> None:
    for normals in (analysis.normals, analysis.initial_normals):
        assert np.abs(np.linalg.norm(normals.compact, axis=1) - 1).max() < 1e-6
        assert normals.compact[:, 2].min() >= 0
    assert np.isfinite(analysis.report.energies).all()
    for picture in (analysis.picture, analysis.base_color, toonkit.relight(analysis, (30, 40))):
        check_picture(picture)


@st.composite
def mutated(draw: st.DrawFn, content: bytes) -> bytes:
    """Overwrite, insert, cut out and repeat parts of a file."""
    data = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(data)))
        new = draw(st.binary(max_size=8) | st.sampled_from([b"\0" * 4, b"\xff" * 4, b"\x7f\xff\xff\xff"]))
        kind = draw(st.sampled_from(["overwrite", "insert", "cut", "repeat", "end"]))
        if kind == "overwrite":
            data[at : at + len(new)] = new
        elif kind == "insert":
            data[at:at] = new
        elif kind == "cut":
            del data[at : at + draw(st.integers(1, 64))]
        elif kind == "repeat":
            data[at:at] = data[at : at + draw(st.integers(1, 64))]
        else:
            del data[at:]
    return bytes(data)


@cache
def picture_file(kind: str) -> bytes:
    file = io.BytesIO()
    image = Image.fromarray(PICTURE.to_rgba())
    (image.convert("RGB") if kind == "JPEG" else image).save(file, kind)
    return file.getvalue()


@fuzz(100)
@given(st.sampled_from(FORMATS).flatmap(lambda kind: mutated(picture_file(kind))))
def test_a_damaged_picture_is_read_or_refused(content: bytes) -> None:
    with refusals():
        check_picture(toonkit.load_image(io.BytesIO(content)))


NUMBERS = st.one_of(
    st.floats(0, 1), st.floats(), st.sampled_from([np.nan, np.inf, -1.0, 1e300, 1e-300, 0.5, 255.0])
)
DTYPES = st.sampled_from([bool, np.uint8, np.int16, np.uint16, np.float16, np.float32, np.float64])


@st.composite
def arrays(draw: st.DrawFn) -> Any:
    """Arrays that are nearly pictures, masks, lights or maps: of any type, with a few odd values."""
    shape = draw(
        st.sampled_from(
            [(24, 24), (24, 24, 3), (24, 24, 4), (3,), (5, 3), SHAPE.mask.shape, (*SHAPE.mask.shape, 3)]
        )
        | hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=6)
    )
    array = np.random.default_rng(draw(st.integers(0, 99))).random(shape)
    for _ in range(draw(st.integers(0, 3))):
        if array.size:
            array.flat[draw(st.integers(0, array.size - 1))] = draw(NUMBERS)
    with np.errstate(all="ignore"):
        kind = draw(DTYPES)
        scaled = array * 255 if np.dtype(kind).kind in "ui" else array
        return np.nan_to_num(scaled).astype(kind) if np.dtype(kind).kind in "uib" else array.astype(kind)


ODD = st.one_of(
    arrays(),
    st.none(),
    st.integers(),
    NUMBERS,
    st.text(max_size=4),
    st.binary(max_size=4),
    st.lists(NUMBERS, max_size=4),
)


@fuzz(60)
@given(ODD, ODD)
def test_any_array_is_a_picture_or_refused(source: Any, mask: Any) -> None:
    with refusals():
        check_picture(toonkit.load_image(source if not isinstance(source, str) else [source], mask=mask))
    with refusals():
        check_picture(ToonImage(source, mask))
    with refusals():
        check_picture(ToonImage(PICTURE.color, SHAPE.mask, alpha=source, fringe=mask))


@fuzz(100)
@given(ODD, ODD)
def test_functions_of_arrays_answer_with_finite_numbers_or_refuse(one: Any, other: Any) -> None:
    with refusals():
        assert np.abs(np.linalg.norm(toonkit.light_direction(one, other)) - 1) < 1e-9
    with refusals():
        assert np.isfinite(toonkit.light_angles(one)).all()
    with refusals():
        normals = toonkit.NormalField(one, other).compact
        assert np.abs(np.linalg.norm(normals, axis=1) - 1).max() < 1e-6
    with refusals():
        normals = toonkit.inflate(one, alpha=other).compact
        assert np.abs(np.linalg.norm(normals, axis=1) - 1).max() < 1e-6
    with refusals():
        color_map = ColorMap(one, other)
        assert np.isfinite(color_map([-1.0, 0.0, 1.0])).all()
    with refusals():
        interval = RAMP.invert(one)
        assert not (interval.lower > interval.upper).any()
    with refusals():
        colors = RAMP(one)
        assert np.isfinite(colors[~np.isnan(np.asarray(one, dtype=float))]).all()
    with refusals():
        assert not (IlluminationInterval(one, other).lower > IlluminationInterval(one, other).upper).any()
    with refusals():
        assert np.isfinite(toonkit.illumination_error(one, other, SHAPE.mask).mean)
    with refusals():
        assert np.isfinite(toonkit.fit_color_map(PICTURE, one).colors).all()
    with refusals():
        assert np.isfinite(toonkit.extract_color_map(PICTURE, one).colors).all()
    with refusals():
        check_picture(toonkit.shade(SHAPE.normals, one, RAMP))


@fuzz(20)
@example(142, "toonkit", None, 0.0)  # all of it is ink
@given(
    st.integers(0, 10**6),
    st.sampled_from(list(toonkit.METHODS)),
    st.none() | st.tuples(st.floats(-1e3, 1e3), st.floats(0, 90)) | ODD,
    st.sampled_from([0.0, 0.02, 0.5, 1.0]),
)
def test_any_drawing_is_analyzed_or_refused(seed: int, method: str, light: Any, noise: float) -> None:
    generator = np.random.default_rng(seed)
    mask = np.zeros((28, 28), bool)
    for _ in range(generator.integers(1, 5)):
        row, column, height, width = generator.integers(0, 20, 4)
        mask[row : row + height, column : column + width] = True
    if noise == 1.0:
        mask &= generator.random(mask.shape) < 0.6
    tones = generator.random((generator.integers(1, 6), 3))
    color = tones[generator.integers(0, len(tones), (7, 7))].repeat(4, 0).repeat(4, 1)
    color = np.clip(color + noise * generator.normal(size=color.shape), 0, 1)
    with refusals():
        check_analysis(toonkit.analyze(ToonImage(color, mask), light, method=method))


@fuzz(60)
@given(
    st.dictionaries(
        st.sampled_from([*RefinementOptions.__dataclass_fields__]), ODD | st.floats(0, 2), max_size=4
    ),
    ODD,
    ODD,
)
def test_a_refinement_of_any_options_ends_in_unit_vectors_or_is_refused(
    options: dict[str, Any], lower: Any, upper: Any
) -> None:
    chosen, light = RefinementOptions(), toonkit.light_direction(135, 45)
    with refusals():
        chosen = RefinementOptions(**options)
    interval = toonkit.illumination_interval(PICTURE, RAMP)
    with refusals():
        interval = IlluminationInterval(lower, upper)
    with refusals():
        refined = toonkit.refine(SHAPE.normals, light, interval, options=chosen)
        assert np.isfinite(refined.report.energies).all()
        assert np.abs(np.linalg.norm(refined.normals.compact, axis=1) - 1).max() < 1e-6


@cache
def archive_file() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "analysis.npz"
        save_analysis(toonkit.analyze(PICTURE, (135, 45), method="lumo"), path)
        return path.read_bytes()


@cache
def archive_members() -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(archive_file())) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@st.composite
def archives(draw: st.DrawFn) -> bytes:
    """Archives with damaged bytes, damaged arrays, or other arrays in the place of theirs."""
    if draw(st.booleans()):
        return draw(mutated(archive_file()))
    members = dict(archive_members())
    name = draw(st.sampled_from(sorted(members)))
    if draw(st.booleans()):
        members[name] = draw(mutated(members[name]))
    else:
        array = io.BytesIO()
        np.save(array, draw(arrays()))
        members[name] = array.getvalue()
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    return file.getvalue()


@fuzz(100)
@given(archives())
def test_a_damaged_archive_is_read_or_refused(content: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "analysis.npz"
        path.write_bytes(content)
        with refusals():
            check_analysis(load_analysis(path))


JSON_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=LONGEST),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=8,
)


@cache
def color_map_file(suffix: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"map{suffix}"
        write_color_map(RAMP, path)
        return path.read_bytes()


@st.composite
def color_map_files(draw: st.DrawFn) -> tuple[str, bytes]:
    suffix = draw(st.sampled_from([".json", ".png"]))
    if suffix == ".png" or draw(st.booleans()):
        return suffix, draw(mutated(color_map_file(suffix)))
    content = json.loads(color_map_file(suffix))
    content[draw(st.sampled_from(sorted(content)))] = draw(JSON_VALUES)
    return suffix, json.dumps(content).encode()


@fuzz(100)
@given(color_map_files())
def test_a_damaged_color_map_is_read_or_refused(file: tuple[str, bytes]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"map{file[0]}"
        path.write_bytes(file[1])
        with refusals():
            assert np.isfinite(read_color_map(path)([-1.0, 0.0, 1.0])).all()


TRIAL = Trial("ball", "plum", "todo", "given")
SIDECAR = {"toonkit": "1", "settings": {}, "digests": {}}


@fuzz(60)
@given(st.data())
def test_a_damaged_record_is_no_record(data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as folder:
        store = RecordStore(Path(folder), SIDECAR)
        store.save(TRIAL, blank_record(TRIAL, "mesh", StudySettings()))
        (path,) = (Path(folder) / "records").iterdir()
        stored = json.loads(path.read_text())
        if data.draw(st.booleans()):
            place = stored if data.draw(st.booleans()) else stored["record"]
            place[data.draw(st.sampled_from(sorted(place)))] = data.draw(JSON_VALUES)
            path.write_text(json.dumps(stored))
        else:
            path.write_bytes(data.draw(mutated(path.read_bytes())))
        assert store.is_done(TRIAL) == (len(store.records()) == 1)
        store.forget(["todo"])
        store.save(TRIAL, blank_record(TRIAL, "mesh", StudySettings()))
        assert store.is_done(TRIAL)
