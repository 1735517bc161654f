"""The house style of printed figures: page, type, and one color and one name per method, the same in every figure.

A figure is a `matplotlib.figure.Figure` of its own, never one of pyplot's, so that making one leaves nothing behind.
"""

from __future__ import annotations

import textwrap
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
import matplotlib.style
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

PAGE_WIDTH = 7.0
"""Inches across both columns of a journal's page."""

PAD = 0.025
"""Inches around each panel."""

METHOD_COLORS: dict[str, str] = {
    "toonkit": "#0072b2",
    "classical": "#ccbc66",
    "todo": "#d55e00",
    "lumo": "#56b4e9",
    "lambert": "#882255",
    "flat": "#8c8c8c",
}
"""Method -> its color in every chart. Any two stay apart for readers who see no red, no green or no blue."""

METHOD_LABELS: dict[str, str] = {
    "truth": "Ground truth",
    "toonkit": "toonkit",
    "classical": "classical",
    "todo": "Todo & Yamaguchi",
    "lumo": "Lumo",
    "lambert": "Lambert",
    "flat": "Flat",
}
"""Method -> its name in print."""

INK = "#1f1f21"
"""Text, and the truth where it is drawn beside methods."""

QUIET = "#75757a"
"""Frames, second lines of a label, and lines that only guide the eye."""

GROUND = "#f5f4f1"
"""Behind panels that belong together."""

TEXT_SIZE = 8.0
SMALL = 7.0
"""Points: labels, and what stands below them."""

FONT = "DejaVu Sans"
"""It comes with matplotlib, so a figure looks the same on every machine."""

_WIDE_LETTER = 0.61
"""Width of a letter in a wide font, as a share of the type's size."""

_STYLE: dict[str, Any] = {
    "figure.dpi": 144,
    "figure.facecolor": "white",
    "savefig.dpi": 300,
    "font.size": TEXT_SIZE,
    "text.color": INK,
    "axes.titlesize": TEXT_SIZE,
    "axes.titlepad": 4.0,
    "axes.labelsize": TEXT_SIZE,
    "axes.labelcolor": INK,
    "axes.labelpad": 2.5,
    "axes.edgecolor": QUIET,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.unicode_minus": True,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.major.pad": 2.0,
    "ytick.major.pad": 2.0,
    "lines.linewidth": 1.2,
    "patch.linewidth": 0.6,
    "legend.fontsize": SMALL,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "image.interpolation": "antialiased",
    "pdf.fonttype": 42,  # letters stay letters in the file, which journals ask for
    "svg.fonttype": "none",
}


@contextmanager
def figure_style() -> Generator[None]:
    """
    Draw in the house style: white page, sans serif of 7 and 8 points, thin axes.

    What is made inside keeps the style when it is shown or saved outside.
    """
    # After a reset: what the user's own matplotlibrc says may not fit the page.
    # The font by name: "sans-serif" would be looked up again, in the style of whoever saves the figure.
    with mpl.style.context({**_STYLE, "font.family": [FONT]}, after_reset=True):
        yield


def text_width(text: str, size: float = TEXT_SIZE) -> float:
    """Return inches that are enough for the longest line of a text in any usual font."""
    return _WIDE_LETTER * size / 72 * max(map(len, text.split("\n")))


def fold(text: str, width: float, *, size: float = TEXT_SIZE) -> str:
    """Break a text at spaces so that it fits a width in inches in any usual font; longer words stay whole."""
    letters = max(int(width / text_width(" ", size)), 1)
    return textwrap.fill(text, letters, break_long_words=False, break_on_hyphens=False)


def new_figure(height: float, *, width: float = PAGE_WIDTH, gap: float = 0.015) -> Figure:
    """
    Return an empty page, sizes in inches, whose layout keeps labels from overlapping; call it inside `figure_style`.

    The gap between columns is a share of their width.
    """
    layout = ConstrainedLayoutEngine(w_pad=PAD, h_pad=PAD, wspace=gap, hspace=0.015)
    return Figure(figsize=(width, height), layout=layout)
