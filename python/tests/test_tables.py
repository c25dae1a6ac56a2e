"""Tables of pandas and Arrow, with the units in the names of their columns."""

from __future__ import annotations

import numpy as np
import pandas
import pyarrow
import samara_tpf as samara


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
