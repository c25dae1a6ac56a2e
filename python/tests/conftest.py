"""The program of the same wheel, and its files as arrays."""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
import sysconfig
from pathlib import Path

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
