# SPDX-License-Identifier: MIT
"""The odometry, frame by frame."""
from __future__ import annotations

import json
import os
import warnings
from typing import Literal

import numpy as np
import numpy.typing as npt

from turnscale import _native
from turnscale._commands import Drive
from turnscale._native import Camera, FrameResult
from turnscale._options import Height, Path, Rotation, Settings, list_text, settings_file
from turnscale._tables import from_csv, from_tum


def _drive_from(tables: _native.Tables) -> Drive:
    return Drive(trajectory=from_csv(tables.trajectory), turns=from_csv(tables.turns), speed=from_csv(tables.speed),
                 scale=from_csv(tables.scale), camera_rotation=from_csv(tables.camera_rotation), live=from_tum(tables.live),
                 landmarks=tables.landmarks, summary=json.loads(tables.summary))


class Odometry:
    """Estimates the trajectory of a camera on a car, one image after the other.

    camera: Camera, or a file that Camera.read reads.
    mask: image file or uint8 array of shape (height, width), of which black pixels (0) are left out of all images.
    The other options are those of `run`: lever_arm, lever_arm_sigma, camera_height (m), vehicle (file), side_slip,
    side_slip_sigma (s^2/m), camera_rotation (degrees), method, settings (file or mapping), threads.

    threads is OpenCV's number of threads, in the whole process.

    Without lever_arm, camera_height and vehicle the trajectory is up to scale. Calls release Python's lock; those of
    several threads on one Odometry come one after the other. Raises ValueError where an option cannot be used.
    """

    def __init__(self, camera: Camera | Path, *, lever_arm: float | None = None, lever_arm_sigma: float | None = None,
                 camera_height: Height | None = None, vehicle: Path | None = None, side_slip: float | None = None,
                 side_slip_sigma: float | None = None, camera_rotation: Rotation | None = None,
                 method: Literal["smoothed", "turns", "paper"] | None = None, settings: Settings | None = None,
                 mask: Path | npt.NDArray[np.uint8] | None = None, threads: int = 2) -> None:
        name = None
        if not isinstance(camera, Camera):
            name, camera = os.fspath(camera), Camera.read(camera)
        pixels = mask if isinstance(mask, np.ndarray) else None
        with settings_file(settings) as file:
            self._native = _native.FrameByFrame(camera, {
                "camera_name": name, "lever_arm": lever_arm, "lever_arm_sigma": lever_arm_sigma, "camera_height": list_text(camera_height),
                "vehicle": vehicle, "side_slip": side_slip, "side_slip_sigma": side_slip_sigma,
                "camera_rotation": list_text(camera_rotation), "method": method, "settings": file,
                "mask": mask if pixels is None else None, "threads": threads})
        if pixels is not None:
            self._native.set_mask(pixels)

    def process(self, image: npt.NDArray[np.uint8] | None, time: float) -> FrameResult:
        """Processes the next image and returns the online estimate of its pose.

        image: gray, uint8 of shape (height, width); rows may be apart (a crop), pixels of a row are side by side. It is
            neither copied nor kept. None where the frame has no usable image: its pose is predicted.
        time: seconds, after that of the frame before.

        Raises ValueError where the image is of another kind or size, the time does not increase, or times are so far
        apart that they cannot be seconds.
        """
        if image is None:
            return self._native.process_unreadable(time)
        return self._native.process(image, time)

    def finish(self) -> Drive:
        """Ends the drive, adjusts it as a whole, which may take minutes after hours of driving, and returns `results`.
        No image may follow. Issues the warnings that `run` does."""
        self._native.finish()
        tables = self._native.tables()
        for warning in tables.warnings:
            warnings.warn(warning, stacklevel=2)
        return _drive_from(tables)

    def results(self) -> Drive:
        """Refined poses, turns, speed and scale of the drive so far, with the digits of the program's files, and what
        the summary of a run would say of it (`summary`, `summary["warnings"]`)."""
        return _drive_from(self._native.tables())

    @property
    def camera(self) -> Camera:
        """The camera, with the image size once there was an image."""
        return self._native.camera

    @property
    def scale_state(self) -> str:
        """'pending', 'observed', 'held' or 'road'."""
        return self._native.scale_state

    @property
    def frames(self) -> int:
        """Number of frames so far."""
        return self._native.frames
