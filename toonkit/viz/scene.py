"""A PyVista scene of a normal field: the height surface that it bounds, and arrows along its normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from toonkit._validation import FloatArray, same_shape
from toonkit.heightfield import HeightField
from toonkit.model.image import ToonImage
from toonkit.model.normals import NormalField
from toonkit.viz.height_grid import DEFAULT_SIZE, HeightGrid, reduce_to_grid

ARROW_COLOR = "#e8862e"
CLAY = np.array([0.79, 0.77, 0.74])

VIEW_FROM = np.array([0.45, 0.35, 1.15])
"""From where a scene is seen first: slightly above and aside."""


@dataclass(frozen=True, eq=False)
class HeightScene:
    """
    A surface and the arrows on it, in pixels of the (reduced) picture, x right, y up, z toward the viewer.

    Attributes
    ----------
    surface : pyvista.PolyData
        The height surface, with point array "color" (uint8 RGB).
    arrows : pyvista.PolyData
        Arrow glyphs.
    """

    surface: pv.PolyData
    arrows: pv.PolyData

    def plotter(self, *, background: str = "#26272b", off_screen: bool = True) -> pv.Plotter:
        """
        Return a plotter with the scene in it, seen from slightly above and aside. Nothing is rendered.

        Parameters
        ----------
        background : str, optional
            Color behind the surface.
        off_screen : bool, optional
            Whether `show` and `screenshot` work without a window.

        Returns
        -------
        pyvista.Plotter
            For `show`, `screenshot` or `export_html`.
        """
        plotter = pv.Plotter(off_screen=off_screen)
        plotter.set_background(background)
        plotter.add_mesh(
            self.surface, scalars="color", rgb=True, smooth_shading=True, specular=0.15, show_scalar_bar=False
        )
        plotter.add_mesh(self.arrows, color=ARROW_COLOR, smooth_shading=True)
        center = np.asarray(self.surface.center)
        # The box's diagonal fits into the view angle, whatever the shape of the window that shows it.
        distance = self.surface.length / 2 / np.tan(np.deg2rad(plotter.camera.view_angle / 2))
        plotter.camera.focal_point = tuple(center)
        plotter.camera.position = tuple(center + distance * VIEW_FROM / np.linalg.norm(VIEW_FROM))
        plotter.camera.up = (0.0, 1.0, 0.0)
        return plotter


def height_scene(
    normals: NormalField, color: ToonImage | None = None, *, size: int = DEFAULT_SIZE
) -> HeightScene:
    """
    Build the height surface of a normal field, with arrows along its normals.

    Parameters
    ----------
    normals : NormalField
        Normals, (H, W).
    color : ToonImage, optional
        A picture of the same size to paint the surface with; clay if not given.
    size : int, optional
        Longest side, in samples, of the surface. Larger fields are downsampled by an integer factor.

    Returns
    -------
    HeightScene
        Surface and arrows.

    Raises
    ------
    ToonkitError
        If the size is below 8, or the reduced object is too small to have a shape.
    """
    grid = reduce_to_grid(normals, size=size)
    if color is None:
        return HeightScene(_surface(grid.field, None), _arrows(grid))
    same_shape("color", color.shape, normals.shape, "the normals")
    return HeightScene(_surface(grid.field, color.color[:: grid.step, :: grid.step]), _arrows(grid))


def _surface(field: HeightField, color: FloatArray | None) -> pv.PolyData:
    """Quads over every four object pixels that form a square."""
    mask = field.mask
    index = np.full(mask.shape, -1)
    index[mask] = np.arange(int(mask.sum()))
    square = mask[:-1, :-1] & mask[1:, :-1] & mask[1:, 1:] & mask[:-1, 1:]
    # Counter-clockwise seen from the viewer: top left, bottom left, bottom right, top right.
    corners = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    quads = np.stack([corner[square] for corner in corners], axis=1)
    surface = pv.PolyData.from_regular_faces(_points(field), quads)
    painted = np.broadcast_to(CLAY, (surface.n_points, 3)) if color is None else color[mask]
    surface.point_data["color"] = np.round(painted * 255).astype(np.uint8)
    return surface


def _arrows(grid: HeightGrid) -> pv.PolyData:
    """Arrows along the normals on a coarse grid of object pixels."""
    mask, chosen = grid.field.mask, grid.arrow_feet
    feet = pv.PolyData(_points(grid.field)[chosen[mask]])
    feet.point_data["normal"] = grid.normals.vectors[mask & chosen].astype(np.float32)
    arrow = pv.Arrow(
        tip_length=0.35, tip_radius=0.11, shaft_radius=0.04, tip_resolution=10, shaft_resolution=8
    )
    return feet.glyph(orient="normal", scale=False, factor=0.9 * grid.arrow_spacing, geom=arrow)


def _points(field: HeightField) -> NDArray[np.float32]:
    """Object pixels in the right-handed frame, shape (P, 3): row 0 of the array is the highest y."""
    rows, columns = np.nonzero(field.mask)
    return np.stack([columns, field.mask.shape[0] - 1 - rows, field.height[field.mask]], axis=1).astype(
        np.float32
    )
