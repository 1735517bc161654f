"""What a visitor of the relight page opens: a sample, a picture, a layered document, or what was saved. Knows no panel."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import PurePosixPath

import numpy as np

import toonkit
from toonkit import LayeredDrawing, ToonAnalysis, ToonkitError
from toonkit._validation import BoolArray, collect_warnings, refuse
from toonkit.samples import PREFIX, sample_path
from toonkit.viz.relight_page.analyses import Answer, Evidence, Question, base_of, digest_of
from toonkit.viz.relight_page.corrections import MaterialCorrections
from toonkit.viz.relight_page.session_file import SUFFIX, SavedWork, is_saved_work, read_saved_work
from toonkit.viz.turns import TURNS, Progress

MOST_FILE_BYTES = 60 * 10**6
"""Largest file that a visitor may open."""


@dataclass(frozen=True, eq=False)
class Opened:
    """
    A drawing as it was opened.

    Attributes
    ----------
    name : str
        Name of its file without folders, or "sample:NAME".
    digest : str
        What tells it from others, by content.
    drawing : LayeredDrawing
        The picture, with the materials and the ink that were given with it, if any.
    highlights : ndarray of bool, shape (H, W), optional
        The highlights that were.
    remarks : tuple of str
        What of the file is ignored or only assumed, a line each.
    saved : SavedWork, optional
        The analysis and the corrections that were in the file.
    sample : str
        Name of the sample that it is; "" for a file.
    """

    name: str
    digest: str
    drawing: LayeredDrawing
    highlights: BoolArray | None = None
    remarks: tuple[str, ...] = ()
    saved: SavedWork | None = None
    sample: str = ""

    @property
    def file_name(self) -> str:
        """Name of its file; "" for a sample."""
        return "" if self.sample else self.name

    @property
    def session_name(self) -> str:
        """Name of the file that a session with it is saved to."""
        stem = self.sample or PurePosixPath(self.name).stem
        return stem.lstrip(".") + SUFFIX

    def evidence(
        self, question: Question, corrections: MaterialCorrections | None, shown: OnScreen | None
    ) -> Evidence:
        """
        Return what to answer a question about it from.

        Parameters
        ----------
        question : Question
            The question.
        corrections : MaterialCorrections or None
            Those of its materials and its shape, if there are any.
        shown : OnScreen or None
            An answer to another question about it, to share what is the same.
        """
        shape = question.shape.corrections(self.drawing.image.shape)
        if shown is None or question.version != shown.question.version:
            evidence = self._materials_evidence(corrections, None if shown is None else shown.answer.analysis)
            return replace(evidence, shape=shape)
        previous = shown.answer.analysis
        if question.shape != shown.question.shape:
            # Refined without its help, so that the order in which something is said does not matter.
            return Evidence(previous.drawing, shape=shape)
        return Evidence(previous.image, previous=previous)

    def _materials_evidence(
        self, corrections: MaterialCorrections | None, shown: ToonAnalysis | None
    ) -> Evidence:
        """Return what is known of the materials, and share what does not depend on them with an analysis of others."""
        ink, highlights = self.drawing.ink, self.highlights
        if corrections is None or corrections.labels_version is None:
            return Evidence(self.drawing.image, self.drawing.materials, ink, highlights)
        ink = ink if corrections.ink is None else corrections.ink
        highlights = highlights if corrections.highlights is None else corrections.highlights
        base = base_of(self.drawing.image, shown, (ink, highlights))
        return Evidence(base, corrections.labels, ink, highlights)


@dataclass(frozen=True, eq=False)
class OnScreen:
    """A drawing, the question that was asked of it, and the answer that is on screen."""

    opened: Opened
    question: Question
    answer: Answer


def open_sample(name: str) -> Opened:
    """Open a drawing that ships with toonkit."""
    image = toonkit.load_image(sample_path(name))
    return Opened(PREFIX + name, digest_of(image), LayeredDrawing(image), sample=name)


def check_file(name: str, content: object) -> None:
    """Refuse what is text, as browsers tell, or too large."""
    if not isinstance(content, bytes):
        raise refuse("source", "must be a picture, or work that was saved", f"the text {name}")
    if len(content) > MOST_FILE_BYTES:
        rule = f"must have at most {MOST_FILE_BYTES // 10**6} MB"
        raise refuse("source", rule, f"{len(content) / 10**6:.0f} MB")


def open_file(name: str, content: bytes, progress: Progress) -> Opened:
    """
    Open the content of a file.

    Parameters
    ----------
    name : str
        Its name, perhaps with folders.
    content : bytes
        A picture or a layered document, as `toonkit.load_layers` reads it, or what `toonkit.viz.relight_page.session_file`
        or `ToonAnalysis.save` has written.
    progress : callable
        Told that others come first.

    Raises
    ------
    ToonkitError
        If it is none of these.
    """
    name = name.rpartition("/")[2] or "drawing"
    if is_saved_work(content):
        with TURNS.turn(progress):
            saved = read_saved_work(content, name)
        image, given = saved.analysis.image, saved.given
        drawing = LayeredDrawing(image, given.materials, given.ink)
        digest = hashlib.blake2b(content, digest_size=16).hexdigest()
        return Opened(name, digest, drawing, given.highlights, saved=saved)
    with collect_warnings() as warned:
        try:
            drawing = toonkit.load_layers(BytesIO(content))
        except ToonkitError as error:
            raise ToonkitError(str(error).replace("a file object", name)) from error
    return Opened(name, _digest(drawing), drawing, remarks=tuple(warned))


def _digest(drawing: LayeredDrawing) -> str:
    """Return what tells a drawing from others: a plain picture from one whose layers say more, too."""
    digest = digest_of(drawing.image)
    told = [layer for layer in (drawing.materials, drawing.ink) if layer is not None]
    if not told:
        return digest
    content = hashlib.blake2b(digest.encode(), digest_size=16)
    for layer in told:
        content.update(np.ascontiguousarray(layer).tobytes())
    return content.hexdigest()
