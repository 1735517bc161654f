"""ToonAnalysis: what every method returns."""

from __future__ import annotations

from dataclasses import dataclass

from toonkit._validation import FloatArray
from toonkit.estimation.color_map_fit import illumination_interval
from toonkit.estimation.reading import reading
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
        The picture.
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
    """

    image: ToonImage
    method: str
    light: FloatArray
    normals: NormalField
    initial_normals: NormalField
    color_map: ColorMap
    report: SolverReport = NOT_REFINED

    @property
    def illumination(self) -> FloatArray:
        """L · N, shape (H, W), NaN outside the mask."""
        return illumination(self.normals, self.light)

    @property
    def picture(self) -> ToonImage:
        """The input as the model paints it, M(L · N), under the input's line art and with its alpha."""
        painted = shade(self.normals, self.light, self.color_map)
        color, read = painted.color.copy(), reading(self.image)
        if read.line_art is not None:
            inked = read.inked_places
            color[inked] = read.line_art.over(color[inked])
        return ToonImage(color, self.image.mask, alpha=self.image.alpha)

    def intervals(self) -> IlluminationInterval:
        """Range of illumination that each pixel's painted color allows, (H, W) bounds, NaN outside the mask."""
        return illumination_interval(self.image, self.color_map)
