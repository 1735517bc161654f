"""What a visitor of the relight page says about the shape of the drawing on screen. Knows no panel."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence

from toonkit.viz.relight_page.corrections import MaterialCorrections
from toonkit.viz.relight_page.shape_marks import NOTHING_SAID


class ShapeActions:
    """Each correction of the shape, as something to ask for: the drawing is refined with it, from what is known of it."""

    @abstractmethod
    async def _correct(self, change: Callable[[MaterialCorrections], None]) -> None:
        """Change the corrections of the drawing on screen, and analyze it with them."""

    async def shape_paint(self, path: Sequence[Sequence[float]], radius: float, kind: str) -> None:
        """Say of what a brush covers that it bulges, is flat or in front, or nothing: see `ShapeMarks.painted`."""
        await self._correct(
            lambda found: found.change_shape(found.shape.painted(path, radius, kind, found.codes))
        )

    async def shape_fill(self, place: Sequence[float], kind: str) -> None:
        """Say it of a connected region of one material."""
        await self._correct(lambda found: found.change_shape(found.shape.filled(place, kind, found.codes)))

    async def shape_tilt(
        self, place: Sequence[float], normal: Sequence[float] | None, radius: float, which: int = -1
    ) -> None:
        """Turn the normal at a place, or no longer: see `ShapeMarks.tilted`."""
        await self._correct(
            lambda found: found.change_shape(found.shape.tilted(place, normal, radius, which, found.codes))
        )

    async def shape_reset(self) -> None:
        """Say nothing about the shape any more."""
        await self._correct(lambda found: found.change_shape(NOTHING_SAID))
