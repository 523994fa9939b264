"""Writing measurement logs: CSV (compiled) or Parquet, with LOG.toml beside."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camrob.errors import LogError
from camrob.measurement.csv_numbers import format_table
from camrob.measurement.log import AXES, DISTANCE, EXTERNAL, MOTOR, NORMAL, ORIENTATION, POSITION, MeasurementLog
from camrob.measurement.log_info import info_text

__all__ = ["write_log"]

_CHUNK = 50_000  # rows at once: some ten MB of text
_BYTES_A_CELL = 26  # the longest double, its sign and a comma
_DECIMALS = {
    **dict.fromkeys(("t", *POSITION, DISTANCE, *NORMAL), 6),
    **dict.fromkeys((*ORIENTATION, *AXES, *EXTERNAL, *MOTOR, *(f"c{n}" for n in AXES + EXTERNAL)), 8),
    "line": 0,
}


def write_log(log: MeasurementLog, path: str | Path) -> None:
    """Write a log as .csv or .parquet, and its facts as .toml beside it; both replace what was there.

    CSV rounds to 1e-6 s and mm, 1e-8 degrees and, for torques, forces and temperatures, 1e-4. Files appear as they are
    written: where they must be whole or absent, write into a staged folder. Raises LogError where pyarrow is missing,
    and OSError where the place can't be written.
    """
    path = Path(path)
    if path.suffix.lower() == ".parquet":
        _write_parquet(log, path)
    else:
        names = tuple(log.columns)
        table = log.matrix(names)
        decimals = np.array([_DECIMALS.get(n, 4) for n in names])
        if np.any(np.abs(table) * 10.0**decimals >= 2.0**53):
            raise LogError("holds values too large for the log format", hint="check their units", path=path)
        buffer = np.empty(_CHUNK * len(names) * _BYTES_A_CELL, np.uint8)
        with path.open("wb") as file:
            file.write((",".join(names) + "\n").encode())
            for start in range(0, len(table), _CHUNK):
                count = format_table(table[start : start + _CHUNK], decimals, buffer)
                file.write(buffer[:count].tobytes())
    path.with_suffix(".toml").write_text(info_text(log.info), encoding="utf-8")


def _write_parquet(log: MeasurementLog, path: Path) -> None:
    """As Parquet; NaN becomes null."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise LogError("writing Parquet needs pyarrow", hint="pip install pyarrow, or write CSV", path=path) from None
    arrays = {name: pyarrow.array(np.array(values), from_pandas=True) for name, values in log.columns.items()}
    parquet.write_table(pyarrow.table(arrays), path)
