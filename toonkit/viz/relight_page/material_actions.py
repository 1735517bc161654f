"""What a visitor of the relight page does to the materials of the drawing on screen. Knows no panel."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from toonkit.model.tone_ramp import ToneRamp
from toonkit.viz.relight_page.corrections import MaterialCorrections


class MaterialActions:
    """Each correction of the materials, as something to ask for: it is shown at once, and then analyzed."""

    @abstractmethod
    async def _correct(self, change: Callable[[MaterialCorrections], None]) -> None:
        """Change the corrections of the drawing on screen, and analyze it with them."""

    async def merge(self, material: int, into: int) -> None:
        """Give all of a material to another one, and analyze the drawing with it."""
        await self._correct(lambda corrections: corrections.merge(material, into))

    async def paint(self, path: Sequence[Sequence[float]], radius: float, material: int) -> None:
        """Give what a brush covers to a material, and analyze the drawing with it: see `MaterialCorrections.paint`."""
        await self._correct(lambda corrections: corrections.paint(path, radius, material))

    async def fill(self, place: Sequence[float], material: int) -> None:
        """Give a connected region to a material, and analyze the drawing with it: see `MaterialCorrections.fill`."""
        await self._correct(lambda corrections: corrections.fill(place, material))

    async def split(self, path: Sequence[Sequence[float]], material: int) -> None:
        """Make what a loop encloses a new material, and analyze the drawing with it: see `MaterialCorrections.split`."""
        await self._correct(lambda corrections: corrections.split(path, material))

    async def recolor(self, material: int, ramp: Mapping[str, Any] | None) -> None:
        """Give a material the tones of a `ToneRamp` with these arguments; None gives it back those it is drawn with."""
        await self._correct(
            lambda corrections: corrections.recolor(material, None if ramp is None else ToneRamp(**ramp))
        )

    async def undo(self) -> None:
        """Take the last correction back."""
        await self._correct(MaterialCorrections.undo)

    async def redo(self) -> None:
        """Do again what was taken back last."""
        await self._correct(MaterialCorrections.redo)

    async def reset_materials(self) -> None:
        """Return to the materials that were found."""
        await self._correct(MaterialCorrections.reset)
