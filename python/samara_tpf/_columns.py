"""Tables of results: arrays by name, each name ending in the unit."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import pandas
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

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        rows = len(next(iter(self._arrays.values()), ()))
        return f"Columns of {rows} rows: {', '.join(self._arrays)}"

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
