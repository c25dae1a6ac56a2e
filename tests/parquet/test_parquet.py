"""DuckDB, Polars and pandas read shards as they are: the queries of docs/clusters.md, against the campaign's own files."""

import csv
import json
import os
import re
import subprocess
from pathlib import Path

import duckdb
import pandas
import polars
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
SAMARA = Path(os.environ.get("SAMARA", REPOSITORY / "target/release/samara"))
TRIALS = 60
SHARDS = 3


def blocks(language):
    """The blocks of a language in docs/clusters.md."""
    page = (REPOSITORY / "docs/clusters.md").read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A campaign of which some trials fail, in shards, merged."""
    assert SAMARA.exists(), f"{SAMARA} is missing: cargo build --release"
    folder = tmp_path_factory.mktemp("campaign")
    campaign = ["x500_drop", "--trials", str(TRIALS), "--bound", "0.4997"]
    for shard in range(SHARDS):
        subprocess.run(
            [SAMARA, "assess", *campaign, "--shard", f"{shard}/{SHARDS}", "--out", "runs/x500"], cwd=folder, check=True, capture_output=True
        )
    merged = subprocess.run([SAMARA, "merge", "runs/x500"], cwd=folder, capture_output=True, text=True)
    assert merged.returncode == 1, merged.stderr
    return folder


def lines(folder, campaign):
    """The lines of a campaign's CSV file."""
    text = (folder / f"runs/x500/campaign_{campaign}.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def campaigns(folder):
    """The campaigns of assess.json, by name."""
    return {c["name"]: c for c in json.loads((folder / "runs/x500/assess.json").read_text(encoding="utf-8"))["campaigns"]}


def test_duckdb(folder, monkeypatch):
    monkeypatch.chdir(folder)
    [query] = blocks("sql")
    rows = duckdb.sql(query).fetchall()
    for name, campaign in campaigns(folder).items():
        of = {safe: (trials, worst) for found, safe, trials, worst in rows if found == name}
        assert sum(trials for trials, _ in of.values()) == TRIALS
        assert of.get(False, (0, None))[0] == campaign["unsafe_trials"]
        assert max(worst for _, worst in of.values()) == campaign["max"]
    found = duckdb.sql("SELECT key, value FROM parquet_kv_metadata('runs/x500/shards/00001-of-00003.parquet')").fetchall()
    metadata = {bytes(key).decode(): bytes(value).decode() for key, value in found}
    manifest = json.loads((folder / "runs/x500/assess_manifest.json").read_text(encoding="utf-8"))
    assert metadata["samara.input_hash"] == manifest["input_hash"]
    assert (metadata["samara.seed"], metadata["samara.version"]) == (str(manifest["seed"]), manifest["version"])
    assert json.loads(metadata["samara.shard"])["first"] == TRIALS // SHARDS


def test_polars(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    [code] = [block for block in blocks("python") if "polars" in block]
    names = {}
    exec(code, names)  # what a reader would paste
    dearest = names["dearest"].collect()
    expected = sorted(lines(folder, "optimal"), key=lambda line: -float(line["j_tpf"]))[:10]
    assert dearest["j_tpf"].to_list() == [float(line["j_tpf"]) for line in expected]
    assert "theta_0_deg" in capsys.readouterr().out
    # Every number of every line, to the bit.
    rows = polars.read_parquet("runs/x500/shards/*.parquet").filter(polars.col("campaign") == "step")
    for line, row in zip(lines(folder, "step"), rows.iter_rows(named=True), strict=True):
        for name, text in line.items():
            assert row[name] == (None if text == "" else float(text)), name


def test_pandas(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    [code] = [block for block in blocks("python") if "pandas" in block]
    names = {}
    exec(code, names)  # what a reader would paste
    rows = names["rows"]
    assert len(rows) == 2 * TRIALS and "j_tpf" in capsys.readouterr().out
    for name, campaign in campaigns(folder).items():
        j_tpf = rows[rows["campaign"] == name]["j_tpf"]
        assert j_tpf.mean() == pytest.approx(campaign["mean"], rel=1e-12)
        assert j_tpf.quantile(0.5, interpolation="lower") == campaign["measures"][0]["p50"]
    assert isinstance(rows, pandas.DataFrame)


def test_a_flight_s_table_of_pandas_polars_or_duckdb_is_its_csv(tmp_path):
    """`samara identify` finds the same in a flight's table, whatever wrote it."""
    def samara(*words, expected=0):
        done = subprocess.run([SAMARA, *words], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == expected, done.stderr
        return done

    samara("drop", "x500_drop", "--set", "duration_s=60", "--no-html", "--out", "flown")
    flight = tmp_path / "flown/flight.csv"
    rows = pandas.read_csv(flight, comment="#")
    rows.to_parquet(tmp_path / "pandas.parquet")
    polars.from_pandas(rows).write_parquet(tmp_path / "polars.parquet", compression="snappy")
    duckdb.sql(f"COPY (SELECT * FROM read_csv('{flight}', comment='#')) TO '{tmp_path}/duckdb.parquet' (FORMAT parquet)")

    def found(table):
        numbers = json.loads(samara("identify", table, "--vehicle", "x500", "--json").stdout)["numbers"]
        assert any(number["found"] for number in numbers)
        return numbers

    of_csv = found("flown/flight.csv")
    for table in ("pandas.parquet", "polars.parquet", "duckdb.parquet"):
        assert found(table) == of_csv, table
    polars.from_pandas(rows).write_parquet(tmp_path / "zstd.parquet", compression="zstd")
    assert "zstd" in samara("identify", "zstd.parquet", "--vehicle", "x500", expected=2).stderr
