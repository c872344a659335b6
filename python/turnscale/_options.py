# SPDX-License-Identifier: MIT
"""Values of options as the program writes them on its command line."""
from __future__ import annotations

import contextlib
import json
import os
import pathlib
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from turnscale._tables import POSE_COLUMNS

Path = Union[str, "os.PathLike[str]"]
Settings = Union[Path, Mapping[str, Any]]
Seconds = Union[float, str]
Rotation = Union[Path, Sequence[float]]
Height = Union[float, str, "tuple[float, float]"]
Poses = Union[Path, "npt.NDArray[Any]"]
"""A trajectory: a file, a table with the columns time (s), x, y, z, qx, qy, qz, qw, such as those of `Drive`, or a float array
(N, 8) in that order. Rows without a pose (NaN) are left out."""


def number_text(value: object) -> str:
    """Every bit of a number."""
    return value if isinstance(value, str) else repr(float(value))  # type: ignore[arg-type]


def list_text(value: object) -> str | None:
    """A number, or several with commas between; paths and texts as they are."""
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return os.fsdecode(value)
    if isinstance(value, Iterable):
        return ",".join(number_text(item) for item in value)
    return number_text(value)


def seconds_text(value: Seconds | None) -> str | None:
    return None if value is None else number_text(value)


def inputs_of(path: Path | Sequence[Path]) -> list[Path]:
    return [path] if isinstance(path, (str, os.PathLike)) else list(path)


@contextlib.contextmanager
def settings_file(settings: Settings | None) -> Iterator[Path | None]:
    """A file with the settings; complaints about given ones call it `settings`."""
    if settings is None or isinstance(settings, (str, os.PathLike)):
        yield settings
        return
    with tempfile.TemporaryDirectory() as folder:
        path = str(pathlib.Path(folder, "settings"))
        # JSON is YAML.
        pathlib.Path(path).write_text(json.dumps(settings, indent=0), encoding="utf-8")
        try:
            yield path
        except ValueError as error:
            raise ValueError(str(error).replace(path, "settings")) from None


def _pose_rows(poses: object, name: str) -> npt.NDArray[np.float64]:
    rows: npt.NDArray[Any] | None = poses if isinstance(poses, np.ndarray) else None
    if rows is not None and rows.dtype.names is not None and set(POSE_COLUMNS) <= set(rows.dtype.names):
        rows = np.stack([rows[column].astype(np.float64) for column in POSE_COLUMNS], axis=-1)
    if rows is None or rows.dtype.kind not in "fiu" or rows.ndim != 2 or rows.shape[1] != len(POSE_COLUMNS):
        raise TypeError(f"{name}: give a file, a table with the columns {', '.join(POSE_COLUMNS)}, or an array of shape "
                        "(N, 8) in that order")
    numbers: npt.NDArray[np.float64] = rows.astype(np.float64)
    posed: npt.NDArray[np.float64] = numbers[~np.isnan(numbers).any(axis=1)]
    return posed


@contextlib.contextmanager
def trajectory_file(poses: Poses, name: str) -> Iterator[Path]:
    """A file with the trajectory; complaints about given poses call it `name`."""
    if isinstance(poses, (str, os.PathLike)):
        yield poses
        return
    rows = _pose_rows(poses, name)
    with tempfile.TemporaryDirectory() as folder:
        path = str(pathlib.Path(folder, name))
        lines = (" ".join(repr(float(number)) for number in row) + "\n" for row in rows)
        pathlib.Path(path).write_text("".join(lines), encoding="ascii")
        try:
            yield path
        except ValueError as error:
            raise ValueError(str(error).replace(path, name)) from None
