"""The notebooks run to their ends, and are kept without what they show."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = Path(__file__).resolve().parents[1] / "notebooks"
QUICK = ["drop"]
SLOW = ["cluster", "learned_policy", "log_to_card", "own_controller"]


def notebook(name: str) -> nbformat.NotebookNode:
    """A notebook of the folder."""
    kept: nbformat.NotebookNode = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)  # type: ignore[no-untyped-call]
    return kept


def test_each_notebook_is_kept_without_what_it_shows() -> None:
    assert sorted(path.stem for path in FOLDER.iterdir()) == sorted(QUICK + SLOW)
    for cell in (cell for name in QUICK + SLOW for cell in notebook(name).cells if cell.cell_type == "code"):
        assert cell.outputs == [] and cell.execution_count is None, cell.source


@pytest.mark.parametrize("name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW)])
def test_a_notebook_runs(name: str, tmp_path: Path) -> None:
    run = notebook(name)
    nbformat.validate(run)
    NotebookClient(run, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    shown = [output.get("data", {}) for cell in run.cells for output in cell.get("outputs", [])]
    assert any("image/png" in data or "image/svg+xml" in data for data in shown)
