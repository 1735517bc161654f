"""Publish a study: put it where the notebooks, the dashboard and the documentation show it.

    toonkit study run -o study/
    python -m benchmarks.publish_study study/

Writes the table as `notebooks/study/trials.csv` with its provenance beside it, the means into `docs/accuracy.md`, and the
errors of all trials as `notebooks/figures/study.png`.
"""

from __future__ import annotations

import argparse
import re
import shutil
from pathlib import Path

import pandas as pd

from toonkit.study.reporting.measure_table import on_track
from toonkit.study.reporting.statistics import method_means
from toonkit.study.reporting.text import means_text
from toonkit.study.table import CSV_NAME, PROVENANCE_NAME, load_trials, write_csv
from toonkit.viz.figures.study_methods import error_distributions

ROOT = Path(__file__).parent.parent
PUBLISHED = ROOT / "notebooks" / "study"
DOCUMENT = ROOT / "docs" / "accuracy.md"
FIGURE = ROOT / "notebooks" / "figures" / "study.png"
SHOWN = ("angular_error", "input_rmse", "relight_rmse", "relight_response")
DOTS_PER_INCH = 150

BLOCK = re.compile(r"(?<=<!-- accuracy: begin -->\n).*?(?=<!-- accuracy: end -->)", re.DOTALL)


def overview(trials: pd.DataFrame) -> str:
    """Return the table that `docs/accuracy.md` shows."""
    return means_text(method_means(trials, SHOWN), row_per="method") + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Put a study where the notebooks and docs/accuracy.md show it."
    )
    parser.add_argument("study", type=Path, help="the folder of `toonkit study run`")
    study = parser.parse_args().study
    PUBLISHED.mkdir(exist_ok=True)
    trials = load_trials(study)
    write_csv(trials, PUBLISHED / CSV_NAME)
    shutil.copyfile(study / PROVENANCE_NAME, PUBLISHED / PROVENANCE_NAME)
    given = on_track(load_trials(PUBLISHED), "given")  # what is read is what is shown
    DOCUMENT.write_text(BLOCK.sub(lambda _: overview(given), DOCUMENT.read_text()))
    error_distributions(given).savefig(FIGURE, dpi=DOTS_PER_INCH)


if __name__ == "__main__":
    main()
