"""
toonkit: the shape and the colors behind a cartoon-shaded drawing, and that drawing under a new light.

The model is c = M(L · N), with a color map M for each material, under ink. Where to read what, in the order of the paper:

    Section 3      toonkit.model                       pictures, lights, normals, color maps, shading
                   toonkit.illustration                what real drawings add: ink, materials, flat shading
    Section 3.1    toonkit.estimation.inflation        initial normals (Eq. 1); shape_prior corrects them, as learned
    Section 3.2    toonkit.estimation.color_map_fit    the color map by rank matching; light_fit the light
    Section 3.3    toonkit.estimation.energy           what is minimized (Eqs. 2 to 6); refinement minimizes it
    Section 3.4    toonkit.relighting                  relighting (Eq. 7)
    Section 4      toonkit.methods, toonkit.metrics    the estimators compared, and how; toonkit.study measures them all
"""

from toonkit._validation import ToonkitError, ToonkitWarning
from toonkit.analysis import ToonAnalysis
from toonkit.estimation.color_map_extraction import extract_color_map
from toonkit.estimation.color_map_fit import fit_color_map, fit_color_maps, illumination_interval
from toonkit.estimation.energy import RefinementOptions
from toonkit.estimation.inflation import inflate
from toonkit.estimation.light_fit import LightEstimate, estimate_light
from toonkit.estimation.preparation import find_materials
from toonkit.estimation.refinement import Refinement, refine
from toonkit.export.archive import load_analysis
from toonkit.frames.analysis import FrameAnalysis, analyze_frames
from toonkit.heightfield import HeightField, height_map, height_mesh
from toonkit.methods import METHODS, analyze
from toonkit.metrics import (
    ErrorSummary,
    angular_error,
    color_difference,
    color_rmse,
    illumination_error,
    relight_response,
)
from toonkit.model.color_map import ColorMap, IlluminationInterval
from toonkit.model.frame_files import Frames, read_frames
from toonkit.model.image import ToonImage
from toonkit.model.layer_loading import LayeredDrawing, load_layers
from toonkit.model.light import light_angles, light_direction
from toonkit.model.loading import load_image
from toonkit.model.materials import Materials
from toonkit.model.normal_map_loading import read_normal_map
from toonkit.model.normals import NormalField
from toonkit.model.shading import illumination, shade
from toonkit.model.shape_corrections import NormalHint, ShapeCorrections
from toonkit.model.tone_ramp import ToneRamp
from toonkit.numerics.report import SolverReport
from toonkit.relighting import relight

__version__ = "0.2.0"

__all__ = [
    "METHODS",
    "ColorMap",
    "ErrorSummary",
    "FrameAnalysis",
    "Frames",
    "HeightField",
    "IlluminationInterval",
    "LayeredDrawing",
    "LightEstimate",
    "Materials",
    "NormalField",
    "NormalHint",
    "Refinement",
    "RefinementOptions",
    "ShapeCorrections",
    "SolverReport",
    "ToneRamp",
    "ToonAnalysis",
    "ToonImage",
    "ToonkitError",
    "ToonkitWarning",
    "analyze",
    "analyze_frames",
    "angular_error",
    "color_difference",
    "color_rmse",
    "estimate_light",
    "extract_color_map",
    "find_materials",
    "fit_color_map",
    "fit_color_maps",
    "height_map",
    "height_mesh",
    "illumination",
    "illumination_error",
    "illumination_interval",
    "inflate",
    "light_angles",
    "light_direction",
    "load_analysis",
    "load_image",
    "load_layers",
    "read_frames",
    "read_normal_map",
    "refine",
    "relight",
    "relight_response",
    "shade",
]
