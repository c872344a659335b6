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

from turnscale._native import Camera

Path = Union[str, "os.PathLike[str]"]
Settings = Union[Path, Mapping[str, Any]]
Seconds = Union[float, str]
Rotation = Union[Path, Sequence[float]]
Height = Union[float, str, "tuple[float, float]"]


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


def camera_options(camera: Camera | Path | None) -> dict[str, Any]:
    return {"camera_object" if isinstance(camera, Camera) else "camera": camera}


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
