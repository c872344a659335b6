# SPDX-License-Identifier: MIT
"""The manifest: a CSV file with one drive per row."""
import csv
import dataclasses
import difflib
import functools
import hashlib
import json
import math
import pathlib
import re

from .errors import InputError

# Columns that are options of `turnscale run` of the same name.
PATHS = ("camera", "mask", "timestamps", "settings", "truth", "floor_plan")
NUMBERS = ("fov", "fps", "lever_arm", "lever_arm_sigma", "side_slip", "side_slip_sigma", "max_frames", "rotate",
           "threads")
TEXTS = ("topic", "start", "end", "method", "frame", "camera_height", "camera_rotation")
FLAGS = ("camera_refine", "no_report")
# `vehicle` is the car's name here, so the option has another one.
VEHICLE_FILE = "vehicle_file"
COLUMNS = ("drive", "input", "vehicle", VEHICLE_FILE, *PATHS, *NUMBERS, *TEXTS, *FLAGS)

# Files and folders beside those of the drives.
RESERVED = ("failed", "first_pass", "logs", "table.csv", "vehicles.csv")
SAFE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,119}")
SEPARATOR = ";"
YES, NO = ("1", "yes", "true"), ("", "0", "no", "false")
# Options that do not change the result.
WITHOUT_EFFECT = ("--threads",)
MOST_BYTES = 1 << 24  # of a file whose contents are hashed; of larger ones, size and time count


def option_name(column):
    return "--vehicle" if column == VEHICLE_FILE else "--" + column.replace("_", "-")


# Options whose value is a file, also where its name is a number.
FILES = tuple(option_name(column) for column in (VEHICLE_FILE, *PATHS))


def _fingerprint(path):
    try:
        stat = path.stat()
        if stat.st_size > MOST_BYTES:
            return [stat.st_size, stat.st_mtime_ns]
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return "unreadable"  # run says so


@dataclasses.dataclass(frozen=True)
class Drive:
    """One row. `options` are pairs of an option of `run` and its value; a flag's value is None."""

    name: str
    inputs: tuple
    vehicle: str = ""
    options: tuple = ()
    line: int = 0

    def option(self, name):
        return dict(self.options).get(name)

    def value(self, name):
        """Of an option, the same for 1.45 and 1.450: numbers, separated by commas, or else its text."""
        text = self.option(name)
        if name in FILES:
            return text
        try:
            return tuple(float(number) for number in text.split(","))
        except (AttributeError, ValueError):
            return text

    def arguments(self, without=()):
        """Of `turnscale run`, without these options."""
        words = list(self.inputs)
        for option, value in self.options:
            if option not in without:
                words += [option] if value is None else [f"{option}={value}"]
        return words

    def key(self, *more):
        """Changes when the row, a file that its options name, or one of the texts in `more` does."""
        options = [pair for pair in self.options if pair[0] not in WITHOUT_EFFECT]
        parts = [self.inputs, options, more, *([self._contents] if self._contents else [])]
        return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]

    @functools.cached_property
    def _contents(self):
        """What tells changes of the files that options name."""
        return [_fingerprint(pathlib.Path(value)) for option, value in self.options
                if option in (*FILES, "--camera-rotation") and pathlib.Path(value).is_file()]


class _Row:
    """The cells of a line; problems name the line and the column."""

    def __init__(self, path, line, cells):
        self.path, self.line, self.cells = path, line, cells

    def get(self, column):
        return (self.cells.get(column) or "").strip()

    def refuse(self, column, problem):
        raise InputError(f"{self.path}:{self.line}: {column}: {problem}")

    def resolved(self, column, text):
        if "\0" in text:
            self.refuse(column, "holds a NUL character")
        file = self.path.parent / text
        if not file.exists():
            self.refuse(column, f"'{text}' does not exist; paths are relative to the manifest's folder")
        return str(file.absolute())


def _name(row):
    name = row.get("drive")
    if not name:
        row.refuse("drive", "is empty; give each drive a name of its own")
    if not SAFE_NAME.fullmatch(name):
        row.refuse("drive", f"'{name}' is no safe name of a folder; use letters, digits and . _ + - only, first a "
                            "letter or digit")
    if name in RESERVED:
        row.refuse("drive", f"'{name}' is the name of something else in the results; choose another one")
    return name


def _number(row, column, text):
    try:
        if math.isfinite(float(text)):
            return text
    except ValueError:
        pass
    return row.refuse(column, f"'{text}' is no number")


def _options(row):
    for column in (VEHICLE_FILE, *PATHS, *NUMBERS, *TEXTS, *FLAGS):
        text = row.get(column)
        if column in FLAGS:
            if text.lower() in YES:
                yield option_name(column), None
            elif text.lower() not in NO:
                row.refuse(column, f"'{text}' is neither yes nor no")
        elif text:
            if column in PATHS or column == VEHICLE_FILE:
                text = row.resolved(column, text)
            elif column in NUMBERS:
                text = _number(row, column, text)
            elif column == "camera_rotation" and (row.path.parent / text).is_file():
                text = row.resolved(column, text)
            yield option_name(column), text


def _inputs(row):
    parts = [part.strip() for part in row.get("input").split(SEPARATOR)]
    if not any(parts):
        row.refuse("input", "is empty; give the drive's images, videos or bags")
    # An input that is missing costs its drive only: the run says so.
    return tuple(str((row.path.parent / part).absolute()) for part in parts if part)


def _check_header(path, header):
    if len(header) == 1 and SEPARATOR in header[0]:
        raise InputError(f"{path}:1: the only column is '{header[0][:40]}'; separate columns by commas, not by "
                         f"'{SEPARATOR}'")
    for place, column in enumerate(header, start=1):
        if column not in COLUMNS:
            close = difflib.get_close_matches(column, COLUMNS, 1)
            hint = f"did you mean '{close[0]}'?" if close else f"known are {', '.join(COLUMNS)}"
            raise InputError(f"{path}:1: column {place}: unknown column '{column}'; {hint}")
        if column in header[:place - 1]:
            raise InputError(f"{path}:1: column {place}: '{column}' is there twice")
    for column in ("drive", "input"):
        if column not in header:
            raise InputError(f"{path}:1: there is no column '{column}'; the first line names the columns")


def read_manifest(path):
    """The drives, in the order of the file. Throws InputError that names line and column."""
    path = pathlib.Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no text in UTF-8") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    reader = csv.reader(text.splitlines(keepends=True), strict=True)
    drives, lines, header = [], {}, None
    try:
        for cells in reader:
            if not any(cell.strip() for cell in cells):
                continue
            if header is None:
                header = [cell.strip().replace("-", "_") for cell in cells]
                _check_header(path, header)
                continue
            if len(cells) != len(header):
                raise InputError(f"{path}:{reader.line_num}: has {len(cells)} cells, but the first line names "
                                 f"{len(header)} columns; quote cells that hold commas")
            row = _Row(path, reader.line_num, dict(zip(header, cells)))
            name = _name(row)
            # Some file systems do not tell letters of different case apart.
            if name.lower() in lines:
                row.refuse("drive", f"'{name}' is in line {lines[name.lower()]} too; give each drive a name of its own")
            lines[name.lower()] = reader.line_num
            drives.append(Drive(name, _inputs(row), row.get("vehicle"), tuple(_options(row)), reader.line_num))
    except csv.Error as error:
        raise InputError(f"{path}:{reader.line_num}: {error}") from error
    if not drives:
        raise InputError(f"{path}: names no drive; the first line names the columns, each other line is a drive")
    return drives
