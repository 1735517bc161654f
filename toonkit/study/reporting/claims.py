"""The claims of the paper about the methods (Sections 4.2 and 4.3), tested on the study's table."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib.resources import files
from typing import Literal

import numpy as np
import pandas as pd

from toonkit.study.reporting.claim_tests import Check, ClaimTests
from toonkit.study.reporting.measure_table import arrange
from toonkit.study.reporting.statistics import FEWEST, resample

Verdict = Literal["agrees", "partly", "disagrees", "undecided"]

RULE = (
    "A check holds if the 95 % interval of its number lies wholly on the side that the claim says, does not hold if it lies "
    f"wholly on the other, and is undecided in between, or without an interval: of fewer than {FEWEST} shapes or {FEWEST} "
    "color maps there is none. A claim “agrees” if all its checks hold, is “undecided” if all are undecided, and "
    "“disagrees” if none holds and at least one is contradicted, and “partly” otherwise."
)
"""How verdicts are reached, for readers."""


@dataclass(frozen=True)
class Claim:
    """
    A claim of the paper, and its checks on the numbers.

    Attributes
    ----------
    key, section : str
        A letter, and the paper's section.
    text : str
        The claim in our words, close to the paper's.
    checks : tuple of Check
        At least one.
    """

    key: str
    section: str
    text: str
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


def check_claims(trials: pd.DataFrame, *, generator: np.random.Generator | None = None) -> list[Claim]:
    """
    Test the paper's claims, `claims.json`, on the study's table of one light track.

    A claim about a method that is not in the table is undecided. For errors see `arrange`.
    """
    tests = ClaimTests(trials, resample(arrange(trials, "angular_error"), generator=generator))
    stored = json.loads(files("toonkit.study").joinpath("claims.json").read_text(encoding="utf-8"))
    return [
        Claim(
            claim["key"],
            claim["section"],
            claim["claim"],
            tuple(tests.run(**check) for check in claim["checks"]),
        )
        for claim in stored
    ]
