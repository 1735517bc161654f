"""The measures of the study's table: label, unit and ideal value."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Measure:
    """
    A column of measures.

    Attributes
    ----------
    column : str
        Field of `toonkit.study.records.Record`.
    label : str
        What it is called in tables and figures.
    unit : str
        "°", "sRGB", "ΔE00", "s" or empty.
    ideal : float
        The best value: 0 for errors, 1 for the response.
    decimals : int
        Digits worth showing after the point.
    """

    column: str
    label: str
    unit: str
    ideal: float = 0.0
    decimals: int = 3

    def shown(self, value: float) -> str:
        """Return a value with its unit, as a table shows it."""
        unit = self.unit if self.unit == "°" else f" {self.unit}" if self.unit == "s" else ""
        return f"{value:.{self.decimals}f}{unit}"

    @property
    def axis(self) -> str:
        """Label and unit for an axis."""
        return f"{self.label} ({self.unit})" if self.unit else self.label


MEASURES: dict[str, Measure] = {
    measure.column: measure
    for measure in (
        Measure("angular_error", "normals, mean error", "°", decimals=1),
        Measure("angular_error_without_rim", "normals, mean error without rim", "°", decimals=1),
        Measure("angular_error_median", "normals, median error", "°", decimals=1),
        Measure("angular_error_percentile_95", "normals, 95th percentile", "°", decimals=1),
        Measure("illumination_error", "illumination, mean error", ""),
        Measure("illumination_error_without_rim", "illumination, mean error without rim", ""),
        Measure("color_map_rmse", "color map, RMSE", "sRGB"),
        Measure("color_map_rmse_without_rim", "color map, RMSE without rim", "sRGB"),
        Measure("input_rmse", "input, RMSE", "sRGB"),
        Measure("input_rmse_without_rim", "input, RMSE without rim", "sRGB"),
        Measure("input_difference", "input, color difference", "ΔE00", decimals=2),
        Measure("relight_rmse", "relit, RMSE", "sRGB"),
        Measure("relight_rmse_without_rim", "relit, RMSE without rim", "sRGB"),
        Measure("relight_rmse_worst", "relit, RMSE under the worst light", "sRGB"),
        Measure("relight_response", "response to the light", "", ideal=1.0, decimals=2),
        Measure(
            "relight_response_without_rim", "response to the light without rim", "", ideal=1.0, decimals=2
        ),
        Measure("light_error", "light, error", "°", decimals=1),
        Measure("seconds", "time to analyze", "s", decimals=2),
    )
}
"""Every column of measures by name, in the order of the table."""
