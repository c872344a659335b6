# SPDX-License-Identifier: MIT
"""Tables of the program's CSV files as structured arrays."""
from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np
import numpy.typing as npt

Table = npt.NDArray[np.void]

# All other columns are numbers.
_WHOLE = {"first_frame", "first_pose", "frame", "frames", "inliers", "keyframes", "last_frame", "last_pose", "pose",
          "tracked"}
_SWITCH = {"estimated", "keyframe", "moved", "turning", "used"}
_TEXT = {"reason", "scale_state", "state", "unadjusted"}

POSE_COLUMNS = ("time", "x", "y", "z", "qx", "qy", "qz", "qw")


def _column(name: str, cells: list[str]) -> npt.NDArray[Any]:
    if name in _TEXT:
        longest = max((len(cell) for cell in cells), default=0)
        return np.array(cells, dtype=f"U{max(longest, 1)}")
    if name in _WHOLE:
        return np.array([int(cell) for cell in cells], dtype=np.int64)
    if name in _SWITCH:
        return np.array([cell == "1" for cell in cells], dtype=np.bool_)
    return np.array([float(cell) if cell else np.nan for cell in cells], dtype=np.float64)


def _structured(names: list[str], columns: list[npt.NDArray[Any]]) -> Table:
    table = np.empty(len(columns[0]), dtype=[(name, column.dtype) for name, column in zip(names, columns)])
    for name, column in zip(names, columns):
        table[name] = column
    return table


def from_csv(text: str) -> Table:
    """A table with a heading; empty cells of numbers become NaN."""
    rows = list(csv.reader(io.StringIO(text)))
    names, rows = rows[0], rows[1:]
    return _structured(names, [_column(name, [row[i] for row in rows]) for i, name in enumerate(names)])


def from_tum(text: str) -> Table:
    """A trajectory, `time x y z qx qy qz qw` a line."""
    rows = [line.split() for line in text.splitlines()]
    return _structured(list(POSE_COLUMNS), [_column(name, [row[i] for row in rows]) for i, name in enumerate(POSE_COLUMNS)])
