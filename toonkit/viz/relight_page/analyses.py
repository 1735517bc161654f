"""The analyses that the relight page asks for: made one at a time, and kept for going back to them."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import toonkit
from toonkit import ShapeCorrections, ToonAnalysis, ToonImage
from toonkit.estimation.prepared_drawing import PreparedDrawing
from toonkit.samples import sample_light, sample_path
from toonkit.viz.relight_page.codes import LabelVersion
from toonkit.viz.relight_page.corrections import Marks
from toonkit.viz.relight_page.settings import DEFAULT_METHOD
from toonkit.viz.relight_page.shape_marks import NOTHING_SAID, ShapeMarks
from toonkit.viz.turns import TURNS, Progress

KEPT_ANALYSES = 6
"""Analyses kept for going back to a method or a sample without waiting: of the samples, and of a visitor's own."""

KEPT_PIXELS = 1_500_000
"""Pictures larger than this are not kept: an analysis of one takes some 200 bytes a pixel."""


@dataclass(frozen=True)
class Question:
    """
    What is asked: two questions that are equal have the same answer.

    Attributes
    ----------
    digest : str
        That of the picture.
    method : str
        Name of the estimator in METHODS.
    angles : tuple of float
        Azimuth and elevation of the artist's light; empty to have it estimated.
    version : bytes or None
        Materials as `MaterialCorrections` tells them apart; None for those found.
    shape : ShapeMarks
        What is said about its shape.
    """

    digest: str
    method: str
    angles: tuple[float, ...]
    version: LabelVersion | None = None
    shape: ShapeMarks = NOTHING_SAID

    @property
    def is_of_drawing_alone(self) -> bool:
        """Whether nobody has corrected anything."""
        return self.version is None and self.shape == NOTHING_SAID


@dataclass(frozen=True, eq=False)
class Evidence:
    """
    What a question is answered from.

    Attributes
    ----------
    image : ToonImage or PreparedDrawing
        The picture, at best as it was prepared before.
    labels : ndarray of int, shape (H, W), optional
        Its corrected materials, if they differ from those of `previous`.
    ink, highlights : ndarray of bool, shape (H, W), optional
        Its corrected ink, highlights and cast shadows.
    shape : ShapeCorrections, optional
        What is said about its shape, if that differs from what was said for `image`.
    previous : ToonAnalysis, optional
        An analysis of the same picture and materials to start from.
    """

    image: ToonImage | PreparedDrawing
    labels: NDArray[np.integer] | None = None
    ink: NDArray[np.bool_] | None = None
    highlights: NDArray[np.bool_] | None = None
    shape: ShapeCorrections | None = None
    previous: ToonAnalysis | None = None


STARTING = frozenset({"toonkit", "classical"})
"""Methods whose answer depends on the analysis that they start from."""


@dataclass(frozen=True, eq=False)
class Answer:
    """
    An analysis, and how it came about.

    Attributes
    ----------
    analysis : ToonAnalysis
        The analysis.
    is_plain : bool
        Whether `toonkit.analyze` makes the same of the picture's file with nothing but the method and the light.
    """

    analysis: ToonAnalysis
    is_plain: bool = False


Kept = OrderedDict[Question, Answer]

SAMPLES: Kept = OrderedDict()
"""Those of the samples, for all visitors; those of a visitor's own drawings and corrections are kept with their state."""


def answer(question: Question, evidence: Evidence, progress: Progress, kept: Kept) -> Answer:
    """Analyze a picture once its turn has come, unless somebody has done so."""
    with TURNS.turn(progress) as limited:
        if question not in kept:
            analysis = toonkit.analyze(
                evidence.image,
                toonkit.light_direction(*question.angles) if question.angles else None,
                method=question.method,
                materials=evidence.labels,
                ink=evidence.ink,
                highlights=evidence.highlights,
                shape=evidence.shape,
                previous=evidence.previous,
                progress=limited,
            )
            is_plain = question.is_of_drawing_alone and evidence.highlights is None
            if evidence.previous is not None and question.method in STARTING:
                is_plain = False
            found = Answer(analysis, is_plain)
            if analysis.image.mask.size > KEPT_PIXELS:
                return found
            kept[question] = found
            while len(kept) > KEPT_ANALYSES:
                kept.popitem(last=False)
        return kept[question]


def digest_of(image: ToonImage) -> str:
    """Return what tells a picture from others, by content."""
    content = hashlib.blake2b(np.ascontiguousarray(image.pixels).tobytes(), digest_size=16)
    for part in (image.mask, image.alpha):
        content.update(np.ascontiguousarray(part).tobytes())
    return content.hexdigest()


def prepare_sample(name: str) -> None:
    """Analyze a sample ahead of time, so that the next page to open it need not wait."""
    image = toonkit.load_image(sample_path(name))
    question = Question(digest_of(image), DEFAULT_METHOD, sample_light(name))
    answer(question, Evidence(image), lambda _step, _fraction: None, SAMPLES)


def base_of(
    image: ToonImage, shown: ToonAnalysis | None, marks: tuple[Marks | None, Marks | None]
) -> ToonImage | PreparedDrawing:
    """Return the drawing on screen, to share what does not change, unless it was given marks that are taken back."""
    if shown is None:
        return image
    given = shown.drawing.given_ink, shown.drawing.given_highlights
    taken_back = any(old is not None and new is None for old, new in zip(given, marks, strict=True))
    return image if taken_back else shown.drawing
