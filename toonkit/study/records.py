"""Trial and Record: a shape, a color map, a method and a light track, and what was measured."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version
from typing import Literal

import numpy as np

import toonkit
from toonkit.study.painting import StudySettings

LightTrack = Literal["given", "estimated"]
LIGHT_TRACKS: tuple[LightTrack, ...] = ("given", "estimated")
"""Whether a method is given the true light, as in the paper, or works with the estimated one."""


@dataclass(frozen=True, order=True)
class Trial:
    """
    A shape, a color map, a method and a light track.

    Attributes
    ----------
    shape, color_map, method : str
        Names of the shape, the color map and the method.
    light_track : {"given", "estimated"}
        Whether the method is given the true light or works with an estimate.
    """

    shape: str
    color_map: str
    method: str
    light_track: LightTrack

    @property
    def key(self) -> str:
        """Unique key of the trial, usable as a file name."""
        return "--".join((self.shape, self.color_map, self.method, self.light_track))


@dataclass(frozen=True)
class Record:
    """
    Measurements of one trial: a row of the study's table.

    Every error is a mean (or a root mean square, where the name says so) over the mask; `..._without_rim` leaves out the
    one-pixel rim, where a pixel is half background. Relighting errors are sRGB differences, averaged over the new
    lights. Each method paints with the color map it estimated. `error` is set for failed trials, and their measures are NaN.

    Attributes
    ----------
    shape, shape_kind, color_map, method, light_track : str
        The trial; the kind is "primitive", "complex" or "mesh".
    size : int
        Width of the picture in pixels.
    light_azimuth, light_elevation : float
        The true light, degrees.
    pixels : int
        Number of object pixels.
    light_error, light_confidence : float
        Angle between the light used and the true one, degrees (0 where the light is given), and the confidence of the
        estimate, 0 to 1 (1 where the light is given).
    angular_error, angular_error_without_rim, angular_error_median, angular_error_percentile_95 : float
        Angle between estimated and true normals, degrees.
    illumination_error, illumination_error_without_rim : float
        Difference between estimated and true L · N, each with its own light.
    color_map_rmse, color_map_rmse_without_rim : float
        The true normals painted with the estimated color map, against the input; sRGB.
    input_rmse, input_rmse_without_rim, input_difference : float
        Reconstruction of the input versus the input: sRGB root mean square error, and mean CIEDE2000.
    relight_rmse, relight_rmse_without_rim, relight_rmse_worst : float
        Relit pictures against the true ones, sRGB: the mean over the new lights, and the largest.
    relight_response, relight_response_without_rim : float
        Change of the picture under the new lights relative to the change of the true picture, as root mean squares over
        all lights. 1 is right; 0 is no change.
    iterations : int
        Iterations of the refinement.
    converged : bool
        Whether the refinement met its convergence criterion.
    stopped : str
        Why the refinement stopped.
    seconds : float
        Wall-clock seconds of the analysis; other trials may run at the same time. It is the only column that differs
        between two runs of the same trial.
    error : str
        Error of a failed trial; empty if the trial succeeded.
    toonkit, python, numpy, scipy, numba : str
        Package versions.
    """

    shape: str
    shape_kind: str
    color_map: str
    method: str
    light_track: str
    size: int
    light_azimuth: float
    light_elevation: float
    pixels: int = 0
    light_error: float = np.nan
    light_confidence: float = np.nan
    angular_error: float = np.nan
    angular_error_without_rim: float = np.nan
    angular_error_median: float = np.nan
    angular_error_percentile_95: float = np.nan
    illumination_error: float = np.nan
    illumination_error_without_rim: float = np.nan
    color_map_rmse: float = np.nan
    color_map_rmse_without_rim: float = np.nan
    input_rmse: float = np.nan
    input_rmse_without_rim: float = np.nan
    input_difference: float = np.nan
    relight_rmse: float = np.nan
    relight_rmse_without_rim: float = np.nan
    relight_rmse_worst: float = np.nan
    relight_response: float = np.nan
    relight_response_without_rim: float = np.nan
    iterations: int = 0
    converged: bool = False
    stopped: str = ""
    seconds: float = np.nan
    error: str = ""
    toonkit: str = ""
    python: str = ""
    numpy: str = ""
    scipy: str = ""
    numba: str = ""


def blank_record(trial: Trial, shape_kind: str, settings: StudySettings, *, error: str = "") -> Record:
    """Return the record of a trial without measures, which are NaN."""
    azimuth, elevation = settings.light
    return Record(
        shape=trial.shape,
        shape_kind=shape_kind,
        color_map=trial.color_map,
        method=trial.method,
        light_track=trial.light_track,
        size=settings.size,
        light_azimuth=float(azimuth),
        light_elevation=float(elevation),
        error=error,
        toonkit=toonkit.__version__,
        python=platform.python_version(),
        numpy=version("numpy"),
        scipy=version("scipy"),
        numba=version("numba"),
    )
