"""Tables of results: arrays by name, each name ending in the unit."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _show

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

Array = npt.NDArray[np.float64]


class Columns(Mapping[str, npt.NDArray[Any]]):
    """Arrays of one length by name, in the order of the CSV file that the program writes.

    Names end in the unit (``t_s``, ``vn_m_s``); attitudes, throttles and J_state have none. What is empty in the
    file is NaN; a ``j_tpf`` without a number is infinite.
    """

    def __init__(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        self._arrays = dict(arrays)

    @classmethod
    def _of_buffers(cls, buffers: Mapping[str, bytearray]) -> Columns:
        return cls({name: np.frombuffer(buffer, dtype=np.float64) for name, buffer in buffers.items()})

    @classmethod
    def _of_csv(cls, text: str) -> Columns:
        """The columns of the program's CSV: of numbers, but for those with a word in them."""
        names, *rows = csv.reader(line for line in text.splitlines() if not line.startswith("#"))

        def column(cells: list[str]) -> npt.NDArray[Any]:
            try:
                return np.array([float(cell or "nan") for cell in cells])
            except ValueError:
                return np.array(cells)

        return cls({name: column([row[i] for row in rows]) for i, name in enumerate(names)})

    @classmethod
    def _of_rows(cls, rows: Iterable[Mapping[str, Any]]) -> Columns:
        """The columns of rows with the same keys: numbers, whole numbers, yes or no, or words."""
        rows = list(rows)

        def column(cells: list[Any]) -> npt.NDArray[Any]:
            if any(isinstance(cell, str) for cell in cells):
                return np.array(["" if cell is None else cell for cell in cells])
            is_number = None in cells or any(isinstance(cell, float) for cell in cells)
            numbers = [np.nan if cell is None else cell for cell in cells]
            return np.array(numbers, dtype=np.float64 if is_number else None)

        return cls({name: column([row[name] for row in rows]) for name in (rows[0] if rows else ())})

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        rows = len(next(iter(self._arrays.values()), ()))
        return f"Columns of {rows} rows: {', '.join(self._arrays)}"

    def _repr_html_(self) -> str:
        rows = len(next(iter(self._arrays.values()), ()))
        return _show.table(self._arrays, f"{type(self).__name__}: {rows} rows")

    def stacked(self, *names: str) -> Array:
        """The named columns side by side: an array of shape (rows, names)."""
        return np.column_stack([self[name] for name in names]).astype(np.float64, copy=False)

    def to_pandas(self) -> pandas.DataFrame:
        """A pandas data frame with these columns (``pip install 'samara-tpf[tables]'``)."""
        import pandas

        return pandas.DataFrame(self._arrays)

    def to_arrow(self) -> pyarrow.Table:
        """An Arrow table with these columns (``pip install 'samara-tpf[tables]'``).

        What is NaN, because the program's file has nothing there, is null.
        """
        import pyarrow

        def column(array: npt.NDArray[Any]) -> pyarrow.Array:
            is_number = array.dtype.kind == "f"
            return pyarrow.array(array, mask=np.isnan(array)) if is_number else pyarrow.array(array)

        return pyarrow.table({name: column(array) for name, array in self._arrays.items()})

    def to_polars(self) -> polars.DataFrame:
        """A Polars data frame with these columns (``pip install 'samara-tpf[tables]'``); nulls as in Arrow."""
        import polars

        frame = polars.from_arrow(self.to_arrow())
        assert isinstance(frame, polars.DataFrame)
        return frame

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Arrow's PyCapsule interface, by which DuckDB, pandas and others take these columns as they are."""
        stream: object = self.to_arrow().__arrow_c_stream__(requested_schema)
        return stream
