"""Tables of pandas, Polars and Arrow, with the units in the names of their columns."""

from __future__ import annotations

import duckdb
import numpy as np
import pandas
import pyarrow
import samara_tpf as samara
from conftest import assert_converts


def test_a_data_frame_has_the_columns_of_the_file() -> None:
    flight = samara.drop("titan_drop").flight
    frame = flight.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and list(frame.columns) == list(flight)
    assert (frame["vd_m_s"].to_numpy() == flight["vd_m_s"]).all()
    assert set(frame["phase"]) == {"hanging", "falling", "powered"}


def test_an_arrow_table_has_nulls_where_the_file_has_nothing() -> None:
    flight = samara.drop("titan_drop").flight
    table = flight.to_arrow()
    assert isinstance(table, pyarrow.Table) and table.column_names == list(flight)
    assert table["t_powered_s"].null_count == np.isnan(flight["t_powered_s"]).sum() > 0
    assert table["t_s"].null_count == 0
    campaign = samara.assess(trials=16).optimal.to_arrow()
    assert campaign["trial"].to_pylist() == list(range(16))


def test_polars_has_the_nulls_of_arrow() -> None:
    flight = samara.drop("titan_drop").flight
    assert_converts(flight)
    frame = flight.to_polars()
    assert frame["t_powered_s"].null_count() == np.isnan(flight["t_powered_s"]).sum() > 0
    assert (frame["vd_m_s"].to_numpy() == flight["vd_m_s"]).all() and set(frame["phase"]) == set(flight["phase"])


def test_arrows_interface_gives_the_columns_to_whoever_asks() -> None:
    flight = samara.drop("titan_drop").flight
    taken = pyarrow.table(flight)
    assert taken.equals(flight.to_arrow())
    # The numbers are where they were.
    address = taken["t_s"].chunk(0).buffers()[1].address
    assert address == flight["t_s"].__array_interface__["data"][0]
    counted = duckdb.sql("select phase, count(*), max(down_m) from flight where t_powered_s is null group by phase")
    assert counted is not None
    hanging = flight["phase"] == "hanging"
    assert counted.fetchall() == [("hanging", hanging.sum(), flight["down_m"][hanging].max())]
