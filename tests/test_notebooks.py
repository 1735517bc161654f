"""Every notebook runs from top to bottom, in a kernel of its own."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient
from nbformat import NotebookNode
from nbformat.v4 import new_code_cell

FOLDER = Path(__file__).parent.parent / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
FIGURES = [path for path in NOTEBOOKS if path.stem.startswith("figure_")]

SMALL = "SIZE = 96"
"""Put after a notebook's cell of parameters: what is tested is that it runs, not how it looks in print."""


def with_small_pictures(notebook: NotebookNode) -> NotebookNode:
    """Return a notebook with the cell tagged "parameters" followed by one that overrides it, as papermill does."""
    cells = []
    for cell in notebook.cells:
        cells.append(cell)
        if "parameters" in cell.metadata.get("tags", ()):
            cells.append(new_code_cell(SMALL))
    return NotebookNode({**notebook, "cells": cells})


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the kernel's own libraries, while they connect
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # sockets that zmq closes late
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_notebook_runs_from_top_to_bottom(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(FOLDER.parent))
    notebook = with_small_pictures(nbformat.read(path, as_version=4))
    NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(FOLDER)}}
    ).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert not [output for output in outputs if output.output_type == "error"]
    assert any({"text/html", "image/png"} & set(output.get("data", {})) for output in outputs)


def test_there_is_a_notebook_for_each_figure_of_the_paper() -> None:
    assert [path.stem.split("_")[1] for path in FIGURES] == [str(number) for number in range(1, 9)]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_notebook_is_kept_without_output(path: Path) -> None:
    code = [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]
    assert [cell.source for cell in code if cell.outputs or cell.execution_count is not None] == []


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_the_size_of_a_figure_is_its_first_line_of_code(path: Path) -> None:
    code = [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]
    tagged = [cell.source for cell in code if "parameters" in cell.metadata.get("tags", ())]
    assert tagged == ["SIZE = 512"] == [code[0].source]


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_a_figure_stands_above_its_caption(path: Path) -> None:
    *_, figure, caption = nbformat.read(path, as_version=4).cells
    assert figure.cell_type == "code"
    assert caption.source.startswith(f"**Figure {path.stem.split('_')[1]}.** ")
