"""Findings: the claims of the paper about the methods (Sections 4.2 and 4.3), tested on the numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from toonkit.study.color_maps import Ramp, load_ramps
from toonkit.study.reporting.cells import cells
from toonkit.study.reporting.evidence import Check, Evidence, Outcome
from toonkit.study.reporting.statistics import FEWEST, resample

Verdict = Literal["agrees", "partly", "disagrees", "undecided"]

AS_NEAR = 1.0
"""Degrees by which normals may be worse and still count as near the truth as others."""

RULE = (
    "Each claim is split into checks. A check holds if the 95 % interval of its number (bootstrap over shapes and color "
    "maps) lies wholly on the side that the claim says, does not hold if it lies wholly on the other, and is undecided in "
    f"between. With fewer than {FEWEST} shapes or {FEWEST} color maps there is no interval, and every check is undecided. "
    "The verdict is “agrees” if all checks hold, “disagrees” if none holds and at least one is contradicted, "
    "“undecided” if all are undecided, and “partly” otherwise."
)
"""How verdicts are reached, for readers."""


@dataclass(frozen=True)
class Finding:
    """
    A claim of the paper, and its tests on the numbers.

    Attributes
    ----------
    key, section : str
        A letter, and the paper's section.
    claim : str
        In our words, close to the paper's.
    measured : str
        Which measures test it, and what they do not cover.
    checks : tuple of Check
        At least one.
    """

    key: str
    section: str
    claim: str
    measured: str
    checks: tuple[Check, ...]

    @property
    def verdict(self) -> Verdict:
        """By `RULE`."""
        outcomes = {check.outcome for check in self.checks}
        if outcomes == {"holds"}:
            return "agrees"
        if outcomes == {"undecided"}:
            return "undecided"
        return "partly" if "holds" in outcomes else "disagrees"

    @property
    def evidence(self) -> str:
        """All checks as text."""
        return "; ".join(map(str, self.checks))

    def checks_that(self, outcome: Outcome) -> tuple[Check, ...]:
        """Return the checks that hold, do not hold, or are undecided."""
        return tuple(check for check in self.checks if check.outcome == outcome)


def findings(trials: pd.DataFrame, *, generator: np.random.Generator | None = None) -> list[Finding]:
    """
    Test the paper's claims on the study's table.

    Parameters
    ----------
    trials : DataFrame
        The study's table, of one light track.
    generator : numpy.random.Generator, optional
        Random generator for the bootstrap; seeded by default.

    Returns
    -------
    list of Finding
        One for each claim, in the paper's order. A claim about a method that is not in the table is undecided.

    Raises
    ------
    ToonkitError
        If the table lacks columns, is empty, mixes light tracks or sizes, or repeats a trial.
    """
    evidence = Evidence(trials, resample(cells(trials, "angular_error"), generator=generator))
    return [claim(evidence) for claim in _CLAIMS]


def step_width(ramp: Ramp) -> float:
    """Return the softness of a ramp: the mean width of the steps between its tones, in illumination."""
    return float(np.mean([width for _, width in ramp.steps])) if ramp.steps else 0.0


def disagreements(found: Sequence[Finding]) -> list[str]:
    """
    Describe where the numbers contradict the paper or do not confirm it.

    Parameters
    ----------
    found : sequence of Finding
        What `findings` returned.

    Returns
    -------
    list of str
        A sentence for each check that does not hold, then one for each that is undecided; empty if there is none.
    """
    texts: dict[Outcome, str] = {
        "does not hold": "Contradicted: {says} ({evidence}). Claim {key}, Section {section}.",
        "undecided": "Not shown either way: {says} ({evidence}). Claim {key}, Section {section}.",
    }
    return [
        text.format(says=check.says, evidence=check.evidence, key=finding.key, section=finding.section)
        for outcome, text in texts.items()
        for finding in found
        for check in finding.checks_that(outcome)
    ]


def _lumo_misses_detail(given: Evidence) -> Finding:
    measures = [
        f"{what}{rim}" for what in ("illumination_error", "input_rmse") for rim in ("", "_without_rim")
    ]
    return Finding(
        "a",
        "4.2",
        "Lumo cannot produce the details of illumination, for lack of inner shading constraints.",
        "Illumination and input picture over the object, and inside it without the rim.",
        tuple(given.less(measure, "todo", "lumo") for measure in measures),
    )


def _lambert_repeats_the_input(given: Evidence) -> Finding:
    return Finding(
        "b",
        "4.2",
        "The Lambert assumption recovers the original shading appearance well.",
        "The input as each of the paper's three methods explains it, in sRGB and as a color difference.",
        tuple(
            given.less(measure, "lambert", than)
            for measure in ("input_rmse", "input_difference")
            for than in ("todo", "lumo")
        ),
    )


def _lambert_overfits(given: Evidence) -> Finding:
    ramps = load_ramps()
    softness = {name: step_width(ramp) for name, ramp in ramps.items()}
    tones = {name: float(len(ramp.tones)) for name, ramp in ramps.items() if "hard" in ramp.tags}
    return Finding(
        "c",
        "4.2",
        "Lambert's normal field is over-fitted to the quantized illumination.",
        "The error of its normals against that of the others, and whether its excess over todo grows as steps get harder, "
        "and as hard color maps have fewer tones.",
        (
            given.less("angular_error", "todo", "lambert"),
            given.less("angular_error", "lumo", "lambert"),
            given.ranked("excess grows with hardness of the steps", "lambert", "todo", softness),
            given.ranked("excess grows with fewer tones on hard maps", "lambert", "todo", tones),
        ),
    )


def _todo_is_between(given: Evidence) -> Finding:
    return Finding(
        "d",
        "4.2",
        "The paper's method reproduces the input nearly as Lambert does, with normals as smooth as Lumo's and similar to "
        "the truth.",
        "Input fit between the two, and the error of the normals; smoothness by itself is not measured.",
        (
            given.nearer_to("input_rmse", "todo", "lambert", "lumo"),
            given.no_worse("angular_error", "todo", "lumo", AS_NEAR),
            given.less("angular_error", "todo", "lambert"),
        ),
    )


def _lambert_hardly_answers(given: Evidence) -> Finding:
    response = "relight_response"
    return Finding(
        "e",
        "4.3",
        "Under a new light Lambert's picture changes less noticeably; the paper's method and Lumo change as the truth does.",
        "How much the picture changes, against how much the true one does: 1 is right.",
        (
            given.less(response, "lambert", "todo"),
            given.less(response, "lambert", "lumo"),
            given.as_the_truth(response, "todo"),
            given.as_the_truth(response, "lumo"),
        ),
    )


def _todo_relights_best(given: Evidence) -> Finding:
    measures = ("relight_rmse", "relight_rmse_without_rim")
    return Finding(
        "f",
        "4.3",
        "The paper's method gives both the dynamic illumination change and the details of the shape.",
        "Relit pictures against the true ones, over the object and inside it without the rim.",
        tuple(given.less(measure, "todo", than) for measure in measures for than in ("lumo", "lambert")),
    )


_CLAIMS: tuple[Callable[[Evidence], Finding], ...] = (
    _lumo_misses_detail,
    _lambert_repeats_the_input,
    _lambert_overfits,
    _todo_is_between,
    _lambert_hardly_answers,
    _todo_relights_best,
)
