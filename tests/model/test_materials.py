"""Materials: what follows from their labels."""

from __future__ import annotations

import numpy as np

from toonkit import Materials


def test_shares_are_of_the_object_alone():
    labels = np.array([[-1, 0, 0], [-1, 0, 2]])
    tone = np.zeros((1, 3))
    materials = Materials(labels, (tone, tone, tone), np.ones(3, np.bool_))
    np.testing.assert_allclose(materials.shares, [0.75, 0.0, 0.25])
