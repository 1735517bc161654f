"""ToonAnalysis: what every method returns."""

from __future__ import annotations

from dataclasses import dataclass, field

from toonkit._validation import FloatArray
from toonkit.estimation.color_map_fit import allowed_interval
from toonkit.estimation.light_fit import LightEstimate
from toonkit.estimation.preparation import PreparedDrawing, prepare
from toonkit.model.color_map import ColorMap, IlluminationInterval
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.model.shading import illumination, shade
from toonkit.numerics.report import NOT_REFINED, SolverReport


@dataclass(frozen=True, eq=False)
class ToonAnalysis:
    """
    A picture taken apart into a light, normals and a color map: c = M(L · N).

    Attributes
    ----------
    image : ToonImage
        The picture; given as one that is prepared, it stands for `drawing` as well.
    method : str
        Name of the estimator in `toonkit.METHODS`.
    light : ndarray, shape (3,)
        Unit vector from the surface to the light.
    normals : NormalField
        Refined normals N.
    initial_normals : NormalField
        Inflated normals N0.
    color_map : ColorMap
        M, re-estimated on the refined normals.
    report : SolverReport
        How the refinement went; by default, that there was none.
    light_estimate : LightEstimate or None
        The light with its confidence, if it was estimated; None if it was given.
    drawing : PreparedDrawing
        The picture with what is derived from it alone, for relighting and further analyses; prepared anew by default.
    """

    image: ToonImage
    method: str
    light: FloatArray
    normals: NormalField
    initial_normals: NormalField
    color_map: ColorMap
    report: SolverReport = NOT_REFINED
    light_estimate: LightEstimate | None = None
    drawing: PreparedDrawing = field(kw_only=True, default=None)  # type: ignore[assignment]  # None until __post_init__

    def __post_init__(self) -> None:
        if self.drawing is None or self.drawing.image is not self.image:
            object.__setattr__(self, "drawing", prepare(self.image))
            object.__setattr__(self, "image", self.drawing.image)

    @property
    def illumination(self) -> FloatArray:
        """L · N, shape (H, W), NaN outside the mask."""
        return illumination(self.normals, self.light)

    @property
    def picture(self) -> ToonImage:
        """The input as the model paints it, M(L · N), under the input's line art and with its alpha."""
        painted = shade(self.normals, self.light, self.color_map)
        color, ink = painted.color.copy(), self.drawing.line_art
        if ink is not None:
            inked = self.drawing.inked_places
            color[inked] = ink.over(color[inked])
        return ToonImage(color, self.image.mask, alpha=self.image.alpha)

    def intervals(self) -> IlluminationInterval:
        """Range of illumination that each pixel's painted color allows, (H, W) bounds, NaN outside the mask."""
        return self.drawing.interval(allowed_interval(self.drawing.tones, self.color_map))
