"""What all tests of training share: networks so narrow that a step takes a hundredth of a second."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import torch

from toonkit.training import network


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(network, "SHAPE_WIDTHS", (8, 8, 12, 12))
    monkeypatch.setattr(network, "LIGHT_WIDTHS", (8, 8, 12, 12))


@pytest.fixture
def one_thread() -> Iterator[None]:
    """Sums in the same order every time."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)
