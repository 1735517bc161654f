"""Ranks of tones: against counting, with ties, and of one tone alone."""

from __future__ import annotations

import numpy as np
import pytest

from toonkit.estimation.tone_ranks import ToneRanks


def test_ranks_count_the_darker_pixels() -> None:
    tones = np.random.default_rng(2).choice([0.1, 0.25, 0.5, 0.9], 60).astype(np.float32)
    ranks = ToneRanks.of(tones)
    assert ranks.below.tolist() == [(tones < tone).sum() for tone in tones]
    assert ranks.upto.tolist() == [(tones <= tone).sum() for tone in tones]
    assert ranks.rank == pytest.approx((ranks.below + ranks.upto) / 120)
    assert (ranks.tone.min(), ranks.tone.max()) == (0, 1)


def test_tones_that_an_8_bit_picture_does_not_tell_apart_share_a_place() -> None:
    ranks = ToneRanks.of(np.array([0.5, 0.5001, 0.9], np.float32))
    assert ranks.below.tolist() == [0, 0, 2]
    assert ranks.upto.tolist() == [2, 2, 3]


def test_one_tone_alone_has_the_middle_rank() -> None:
    ranks = ToneRanks.of(np.full(7, 0.3, np.float32))
    assert ranks.tone.tolist() == [0] * 7
    assert ranks.rank.tolist() == [0.5] * 7
