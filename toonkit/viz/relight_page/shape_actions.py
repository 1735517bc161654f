"""What a visitor of the relight page says about the shape of the drawing on screen. Independent of Panel."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence

from toonkit.viz.relight_page.corrections import MaterialCorrections
from toonkit.viz.relight_page.shape_marks import NOTHING_SAID


class ShapeActions:
    """The corrections of the shape that a visitor can make. Each refines the drawing, and reuses what does not change."""

    @abstractmethod
    async def _correct(self, change: Callable[[MaterialCorrections], None]) -> None:
        """Change the corrections of the drawing on screen, and analyze it with them."""

    async def shape_paint(self, path: Sequence[Sequence[float]], radius: float, kind: str) -> None:
        """Mark what a brush covers as bulging, flat or in front, or remove its marks: see `ShapeMarks.painted`."""
        await self._correct(
            lambda found: found.change_shape(found.shape.painted(path, radius, kind, found.codes))
        )

    async def shape_fill(self, place: Sequence[float], kind: str) -> None:
        """Mark a connected region of one material: see `ShapeMarks.filled`."""
        await self._correct(lambda found: found.change_shape(found.shape.filled(place, kind, found.codes)))

    async def shape_tilt(
        self, place: Sequence[float], normal: Sequence[float] | None, radius: float, which: int = -1
    ) -> None:
        """Set, change or remove the normal at a place: see `ShapeMarks.tilted`."""
        await self._correct(
            lambda found: found.change_shape(found.shape.tilted(place, normal, radius, which, found.codes))
        )

    async def shape_reset(self) -> None:
        """Remove all corrections of the shape."""
        await self._correct(lambda found: found.change_shape(NOTHING_SAID))
