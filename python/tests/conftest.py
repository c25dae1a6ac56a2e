"""The program of the same wheel, and its files as arrays."""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
import sysconfig
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samara_tpf import Columns

PROGRAM = Path(sysconfig.get_path("scripts")) / "samara"
MISSIONS = Path(__file__).resolve().parents[2] / "mission"


def run(*arguments: str, expected: int = 0) -> str:
    """What the program prints, ``stdout`` and ``stderr``."""
    # A folder with no missions of its own, so that names mean the built-in ones.
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, cwd="/")
    assert done.returncode == expected, done.stderr
    return done.stdout + done.stderr


def columns_of(file: Path) -> dict[str, list[str]]:
    """The texts of a CSV file's columns."""
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def assert_same(table: Columns, file: Path) -> None:
    """The table is the file: the same names in the same order, the same bits."""
    texts = columns_of(file)
    assert list(table) == list(texts)
    for name, column in texts.items():
        array = table[name]
        if array.dtype.kind == "U":
            assert array.tolist() == column
            continue
        # An empty field has no value: NaN, or infinite where the program leaves out what is not finite.
        empty = np.array([text == "" for text in column], dtype=bool)
        wanted = np.array([float(text or "nan") for text in column])
        assert not np.isfinite(array[empty]).any(), name
        found = array[~empty].astype(np.float64)
        assert (found.view(np.uint64) == wanted[~empty].view(np.uint64)).all(), name


class Page(HTMLParser):
    """A piece of HTML, read: which elements are open, which there were, and the text."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: set[str] = set()
        self.text = ""
        self.feed(html)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.add(tag)
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.add(tag)

    def handle_data(self, data: str) -> None:
        self.text += data


def assert_shows(result: Any, *words: str, has_figure: bool = True) -> None:
    """A result is a line as text, and in a notebook a heading, tables and a figure, whole, with these words."""
    assert repr(result).startswith(f"<{type(result).__name__}: ") and "\n" not in repr(result)
    page = Page(result._repr_html_())
    assert page.open == [] and "strong" in page.elements and page.elements & {"table", "pre"}
    assert not page.elements & {"html", "script", "style"}
    assert ("svg" in page.elements) == has_figure
    for word in words:
        assert word in page.text, word


def assert_converts(table: Columns) -> None:
    """Pandas, Polars and Arrow have its columns and rows, the latter two nulls where there is no number."""
    rows = len(next(iter(table.values())))
    frame, other, arrow = table.to_pandas(), table.to_polars(), table.to_arrow()
    assert frame.shape == other.shape == arrow.shape == (rows, len(table))
    assert list(frame.columns) == other.columns == arrow.column_names == list(table)
    for name, array in table.items():
        nulls = int(np.isnan(array).sum()) if array.dtype.kind == "f" else 0
        assert other[name].null_count() == arrow[name].null_count == nulls


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each test runs in a folder of its own."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="session", autouse=True)
def one_wheel() -> None:
    """Program and module are of one wheel."""
    import samara_tpf

    assert run("--version").split()[1] == samara_tpf.__version__
    assert shutil.which("samara", path=os.fspath(PROGRAM.parent))
