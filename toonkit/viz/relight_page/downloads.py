"""The files that a visitor of the relight page takes along, as they are written to disk. Knows no panel."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from toonkit.model.normals import encode_normal_map
from toonkit.viz.relight_page.corrections import MaterialCorrections
from toonkit.viz.relight_page.session_file import Given, SavedWork, write_session
from toonkit.viz.relight_page.state import RelightState


def relit_png(state: RelightState) -> BytesIO:
    """Return the relit picture as an RGBA PNG file."""
    return _png_file(state.relit().to_rgba())


def normal_map_png(state: RelightState) -> BytesIO:
    """Return the normals as an OpenGL normal map, transparent outside the object."""
    normals = state.analysis.normals
    coverage = np.where(normals.mask, 255, 0).astype(np.uint8)
    return _png_file(np.dstack([encode_normal_map(normals), coverage]))


def analysis_file(state: RelightState) -> BytesIO:
    """Return the whole analysis, edited ramps included, as a file that `toonkit.load_analysis` reads."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "analysis.npz"
        state.recolored.save(path)
        return BytesIO(path.read_bytes())


def session_file(state: RelightState) -> BytesIO:
    """Return the drawing on screen with its analysis, corrections and settings, as a file to go on with later."""
    corrections, opened = state.corrections, state.on_screen.opened
    shown = MaterialCorrections(
        corrections.codes_of(None), corrections.found_ink, corrections.found_highlights
    )
    shown.resume(state.codes, state.ramps, state.shape_marks)  # not what is still being analyzed
    given = Given(opened.drawing.materials, opened.drawing.ink, opened.highlights)
    work = SavedWork(state.analysis, shown, given, dict(state.look), shown.ramps, state.selected)
    return BytesIO(write_session(work, state.recolored))


def _png_file(pixels: NDArray[np.unsignedinteger]) -> BytesIO:
    file = BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    file.seek(0)
    return file
