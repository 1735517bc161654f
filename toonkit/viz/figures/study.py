"""write_figures: the summary figures of a study (Sections 4.2 and 4.3), for the screen and for print."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from toonkit.export.atomic import PathLike, atomic_write
from toonkit.export.folder import make_folder
from toonkit.study.color_maps import load_ramps
from toonkit.study.reporting.comparisons import has_pairs
from toonkit.viz.figures.study_groups import difference_map, error_by_tones, errors_by_group
from toonkit.viz.figures.study_methods import error_distributions, fit_against_response, paired_differences

DOTS_PER_INCH = 200

FIGURES: dict[str, Callable[[pd.DataFrame], Figure]] = {
    "distributions": error_distributions,
    "pairs": paired_differences,
    "trade_off": fit_against_response,
    "by_shape": lambda trials: errors_by_group(trials, "shape"),
    "by_color_map": lambda trials: errors_by_group(trials, "color_map"),
    "difference": difference_map,
    "tones": error_by_tones,
}
"""Name of the file -> what draws it from the table of one light track."""

CAPTIONS: dict[str, str] = {
    "distributions": "Errors of all trials. Above, the share of trials below an error; below, for every method the density, "
    "the quartiles with the median, and the trials.",
    "pairs": "Differences between methods on the same trials, with 95 % intervals: left of 0, the method named first is "
    "better. The percentage is the share of trials that it wins. The intervals are the primary evidence. A dot is filled if "
    "p < 0.05 after Holm's correction, which is approximate: the larger p of Wilcoxon's signed-rank tests over shapes and "
    "over color maps. Without intervals there were too few of either.",
    "trade_off": "How well a method repeats its input, and how much its picture answers a new light. Small dots are trials; "
    "large ones are the methods' means along the fit and medians along the response, with 95 % intervals.",
    "by_shape": "Means of every method on every shape, over the color maps.",
    "by_color_map": "Means of every method on every color map, over the shapes; beside each name its ramp, dark to bright.",
    "difference": "Difference in the normals' mean error between toonkit and the paper's method on every shape and every "
    "color map, both sorted by their means.",
    "tones": "Error of the normals against the number of tones of the hard color maps, with a line through the means of "
    "those with equally many, and against the mean width of the steps of all color maps. A dot is a color map, averaged "
    "over the shapes; the worst one is named.",
}
"""Name of the file -> caption."""


def write_figures(trials: pd.DataFrame, folder: PathLike) -> dict[Path, str]:
    """
    Draw a study's figures into a folder, as PNG of 200 dots per inch and as PDF.

    Parameters
    ----------
    trials : DataFrame
        The study's table, of one light track. Figures that it cannot fill are left out.
    folder : path
        Created if need be; files of the same names are replaced, each once its successor is complete.

    Returns
    -------
    dict
        The files written, in order, each with its caption.

    Raises
    ------
    ToonkitError
        As `toonkit.study.reporting.measure_table.arrange` does, or if the folder cannot be written to.
    """
    target = make_folder(folder)
    written = {}
    for name in _possible(trials):
        figure = FIGURES[name](trials)
        for suffix in (".png", ".pdf"):
            path = target / f"{name}{suffix}"
            # Without its date, the same table gives the same file.
            metadata = {"CreationDate": None} if suffix == ".pdf" else None
            with atomic_write(path) as file:
                figure.savefig(file, format=suffix[1:], dpi=DOTS_PER_INCH, metadata=metadata)
            written[path] = CAPTIONS[name]
    return written


def _possible(trials: pd.DataFrame) -> list[str]:
    methods = set(trials["method"])
    without = {
        "pairs": not has_pairs(trials),
        "difference": not {"toonkit", "todo"} <= methods,
        "tones": set(trials["color_map"]).isdisjoint(load_ramps()),
    }
    return [name for name in FIGURES if not without.get(name, False)]
