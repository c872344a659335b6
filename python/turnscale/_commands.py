# SPDX-License-Identifier: MIT
"""The program's commands: run, calibrate, rescale, evaluate."""
from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import tempfile
from collections.abc import Iterator, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from turnscale import _native
from turnscale._native import Camera, Frame
from turnscale._options import (Height, Path, Rotation, Seconds, Settings, camera_options, inputs_of, list_text, seconds_text,
                                settings_file)
from turnscale._tables import Table, from_csv, from_tum


def _percent(sigma: float | None) -> str:
    return "" if sigma is None else f" +-{100 * sigma:.1f} %"


@dataclasses.dataclass(frozen=True, repr=False)
class Drive:
    """Results of a drive. Tables are structured arrays with the columns and the digits of the program's CSV files, made
    for pandas.DataFrame(table). Numbers without a value are NaN. Lengths are metres, and the map's unit while the scale
    is pending."""

    trajectory: Table
    """Per frame, refined: frame, time (s), state, x, y, z (m), qx, qy, qz, qw (camera to world), scale_state, scale_sigma
    (relative), inliers, tracked, keyframe, psi_deg, theta_deg, turning."""
    turns: Table
    """Per turn: first_frame, last_frame, keyframes, angle_deg, speed_mps, metres_per_unit, sigma, smoothed_metres_per_unit,
    smoothed_sigma, deviation_sigmas, effective_lever_arm_m, used, reason, unadjusted."""
    speed: Table
    """Per frame: time (s), speed_mps and sigma_mps of the rear axle. Empty without metres."""
    scale: Table
    """Per keyframe: frame, time (s), metres_per_unit, sigma (relative). Empty without metres."""
    camera_rotation: Table
    """Per change of the camera-to-vehicle rotation: frame, time (s), yaw_deg, pitch_deg, roll_deg and their sigmas."""
    live: Table
    """Online: each pose as estimated at its frame; time (s), x, y, z (m), qx, qy, qz, qw."""
    landmarks: npt.NDArray[np.float32]
    """The map's points, shape (N, 3), metres."""
    summary: dict[str, Any]
    """As summary.json."""

    def __repr__(self) -> str:
        metres, scale = self.summary.get("distance_m"), self.summary.get("scale") or {}
        length = (f"{self.summary.get('distance_units') or 0:.2f} units" if metres is None
                  else f"{metres:.2f} m{_percent(self.summary.get('path_sigma'))}")
        state = "pending" if metres is None else "known" if scale.get("known", True) else "uncertain"
        return f"<Drive: {len(self.trajectory)} frames, {length}, scale {state}>"

    @property
    def poses(self) -> npt.NDArray[np.float64]:
        """Camera to world for each row of `trajectory`, shape (N, 4, 4); NaN where there is no pose."""
        return _matrices(self.trajectory)


def _matrices(table: Table) -> npt.NDArray[np.float64]:
    x, y, z, w = (table[name] for name in ("qx", "qy", "qz", "qw"))
    # The digits of the files leave a quaternion a little off length 1.
    s = 2 / (x * x + y * y + z * z + w * w)
    poses = np.zeros((len(table), 4, 4))
    poses[:, 0, :3] = np.stack([1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)], axis=1)
    poses[:, 1, :3] = np.stack([s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)], axis=1)
    poses[:, 2, :3] = np.stack([s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)], axis=1)
    poses[:, :3, 3] = np.stack([table["x"], table["y"], table["z"]], axis=1)
    poses[:, 3, 3] = 1
    poses[np.isnan(table["x"])] = np.nan
    return poses


def _landmarks(path: pathlib.Path) -> npt.NDArray[np.float32]:
    """Of map.ply: its vertices without those of cameras, which are red."""
    vertex = np.dtype([("place", "<f4", 3), ("colour", "u1", 3)])
    if not path.exists():
        return np.empty((0, 3), dtype=np.float32)
    _, _, data = path.read_bytes().partition(b"end_header\n")
    points = np.frombuffer(data, dtype=vertex)
    gray = points["colour"][:, 0] == points["colour"][:, 1]
    return np.ascontiguousarray(points["place"][gray], dtype=np.float32)


def read(folder: Path) -> Drive:
    """The results that a run has written to its folder, by `run(..., out=folder)` or by the program.

    Raises ValueError where the folder has none.
    """
    place = pathlib.Path(folder)
    if not (place / "summary.json").is_file():
        raise ValueError(f"{os.fsdecode(folder)}: holds no results; give the --out folder of turnscale run")

    def text(name: str, otherwise: str) -> str:
        path = place / name
        return path.read_text(encoding="utf-8", errors="surrogateescape") if path.exists() else otherwise

    tables = {name: from_csv(text(f"{name}.csv", header)) for name, header in _native.headers().items()}
    return Drive(live=from_tum(text("live.tum", "")), landmarks=_landmarks(place / "map.ply"),
                 summary=json.loads(text("summary.json", "")), **tables)


def run(path: Path | Sequence[Path], *, topic: str | None = None, camera: Camera | Path | None = None, fov: float | None = None,
        camera_refine: bool = False, timestamps: Path | None = None, fps: float | None = None,
        lever_arm: float | None = None, lever_arm_sigma: float | None = None, camera_height: Height | None = None,
        vehicle: Path | None = None, side_slip: float | None = None, side_slip_sigma: float | None = None,
        camera_rotation: Rotation | None = None, method: Literal["smoothed", "turns", "paper"] | None = None,
        frame: Literal["camera", "vehicle"] = "camera", threads: int = 2, settings: Settings | None = None,
        rotate: int = 0, mask: Path | None = None, start: Seconds | None = None, end: Seconds | None = None,
        max_frames: int | None = None, out: Path | None = None, truth: Path | None = None, floor_plan: Path | None = None,
        no_report: bool = False, quiet: bool = True) -> Drive:
    """Estimates the trajectory of a drive from its images, as `turnscale run` does, to the same bits.

    path: KITTI folder, folder of images, video, folder of clips, or bag; or a list of clips or bags that continue one
        another.
    topic: of a bag's images, if it has several.
    camera: Camera, or file with the intrinsics. Without one: those in the input folder or the bag, else estimated.
    fov: horizontal field of view in degrees at which the estimation of the intrinsics starts.
    camera_refine: estimate the intrinsics, starting from the given ones.
    timestamps: file with the times of the frames, s. fps: frames per second.
    lever_arm, lever_arm_sigma: distance from the rear axle forward to the camera, m.
    camera_height: of the camera above the road, m, or (height, sigma).
    vehicle: car.yaml of an earlier run.
    side_slip, side_slip_sigma: slip-angle coefficient c, s^2/m.
    camera_rotation: (yaw, pitch, roll) in degrees, to the right, up, to the right; a YAML file; or "auto".
    method: how metric scale is obtained.
    frame: poses of the camera or of the vehicle (rear axle).
    threads: number of threads; does not affect the result.
    settings: YAML file, or a mapping such as {"corners": {"target": 800}}.
    rotate: the images clockwise by 90, 180 or 270 degrees.
    mask: image of which black pixels are left out of all frames.
    start, end: part of the drive, seconds after its first frame, or "HH:MM:SS".
    max_frames: stop after so many.
    out: folder for the program's files. Without it, nothing is kept on disk.
    truth, floor_plan, no_report: of report.html in `out`.
    quiet: False prints the progress on standard error.

    Warnings are those of the module warnings. Ctrl-C stops after the current frame; with `out`, the results so far are
    there (`read`). Raises ValueError where the input cannot be used, and RuntimeError.
    """
    if out is None and (truth is not None or floor_plan is not None):
        raise ValueError("--truth: is shown in report.html; give out")
    with settings_file(settings) as file, tempfile.TemporaryDirectory() as scratch:
        folder = scratch if out is None else out
        _native.run({
            "inputs": inputs_of(path), "topic": topic, **camera_options(camera), "fov": fov, "camera_refine": camera_refine,
            "timestamps": timestamps, "fps": fps, "lever_arm": lever_arm, "lever_arm_sigma": lever_arm_sigma,
            "camera_height": list_text(camera_height), "vehicle": vehicle, "side_slip": side_slip,
            "side_slip_sigma": side_slip_sigma, "camera_rotation": list_text(camera_rotation), "method": method,
            "frame": frame, "threads": threads, "settings": file, "rotate": rotate, "mask": mask,
            "start": seconds_text(start), "end": seconds_text(end), "max_frames": max_frames, "out": folder,
            "truth": truth, "floor_plan": floor_plan, "no_report": no_report or out is None, "quiet": quiet}, out is not None)
        return read(folder)


class Frames(Iterator[Frame]):
    """The images of a drive in order, as `run` reads them, decoded ahead.

    path, topic, camera, timestamps, fps, rotate, mask, start, end, max_frames: as for `run`.

    Raises ValueError where the drive or one of its images cannot be used. Warns of clips that are left out, and of a
    drive that ends early.
    """

    def __init__(self, path: Path | Sequence[Path], *, topic: str | None = None, camera: Camera | Path | None = None,
                 timestamps: Path | None = None, fps: float | None = None, rotate: int = 0,
                 mask: Path | None = None, start: Seconds | None = None, end: Seconds | None = None,
                 max_frames: int | None = None) -> None:
        self._reader = _native.DriveReader({
            "inputs": inputs_of(path), "topic": topic, **camera_options(camera), "timestamps": timestamps, "fps": fps,
            "rotate": rotate, "mask": mask, "start": seconds_text(start), "end": seconds_text(end),
            "max_frames": max_frames})

    def __iter__(self) -> Frames:
        return self

    def __next__(self) -> Frame:
        return self._reader.__next__()

    @property
    def expected(self) -> int:
        """Number of frames; 0 if not known before the end."""
        return self._reader.expected

    @property
    def camera(self) -> Camera | None:
        """The camera that is given or comes with the drive."""
        return self._reader.camera


@dataclasses.dataclass(frozen=True, repr=False)
class Calibration:
    """Camera-to-vehicle rotation, and the lever arm where it could be estimated or was given."""

    yaw_deg: float
    """To the right."""
    pitch_deg: float
    """Up."""
    roll_deg: float
    """Leaning right."""
    yaw_sigma_deg: float
    pitch_sigma_deg: float
    roll_sigma_deg: float
    vehicle_from_camera: npt.NDArray[np.float64]
    """The rotation as a matrix, shape (3, 3)."""
    lever_arm: float | None
    """Metres."""
    lever_arm_sigma: float | None
    """Metres; None if it was given."""
    side_slip: float | None
    """c, s^2/m."""
    side_slip_sigma: float | None
    """Estimated or assumed; None if the side slip is neglected."""
    lever_arm_slip_correlation: float
    """Of the errors of lever arm and side slip; 0 if the lever arm was given."""
    confidence: float
    """Ratio of the two smallest singular values; at least 2.6 is needed."""
    frames: int
    steps: int
    turns: int
    turning_deg: float
    """Of all turns together."""
    note: str
    """What to know of the motion; may be empty."""
    history: Table
    """The online estimate, step by step: time (s), frames, psi_deg, singular_value_1 to 4, yaw_deg, pitch_deg, roll_deg and
    their sigmas, moved."""
    yaml: str
    """calibration.yaml, for `camera_rotation` and `vehicle` of `run`."""

    def __repr__(self) -> str:
        angles = ", ".join(f"{name} {angle:+.2f} +-{sigma:.2f} deg" for name, angle, sigma in (
            ("yaw", self.yaw_deg, self.yaw_sigma_deg), ("pitch", self.pitch_deg, self.pitch_sigma_deg),
            ("roll", self.roll_deg, self.roll_sigma_deg)))
        arm = "no lever arm" if self.lever_arm is None else f"lever arm {self.lever_arm:.3f} m"
        return f"<Calibration: {self.frames} frames, {angles}, {arm}>"


def calibrate(path: Path | Sequence[Path] | None = None, *, trajectory: Path | None = None,
              axes: Literal["auto", "camera", "flu", "frd"] = "auto", topic: str | None = None,
              camera: Camera | Path | None = None, fov: float | None = None, camera_refine: bool = False,
              timestamps: Path | None = None, fps: float | None = None, settings: Settings | None = None,
              rotate: int = 0, mask: Path | None = None, start: Seconds | None = None, end: Seconds | None = None,
              max_frames: int | None = None, speed: Path | None = None, distance: float | None = None,
              metric: bool = False, lever_arm: float | None = None, side_slip: float | None = None,
              fit_side_slip: bool = False, history: Path | None = None, out: Path | None = None,
              quiet: bool = True) -> Calibration:
    """Estimates the camera-to-vehicle rotation from the images of a drive or from a trajectory, as `turnscale calibrate`.

    path: images of the drive, as for `run`. trajectory: instead, a TUM, KITTI or EuRoC file, in any unit of length, or
        the folder of a run.
    axes: of the trajectory's poses.
    speed: file with one `time, speed` a line (s; m/s, or the unit of a first line such as `time, speed_kmh`);
        distance: path length, m; metric: the trajectory is in metres; each lets the lever arm be estimated, too.
    lever_arm: known, m.
    side_slip: c, s^2/m. fit_side_slip: estimate it.
    history, out: files to write; nothing is written without.
    The others are those of `run`.

    Raises ValueError where the input cannot be used or does not suffice, and RuntimeError.
    """
    with settings_file(settings) as file:
        found = _native.calibrate({
            "inputs": None if path is None else inputs_of(path), "trajectory": trajectory, "axes": axes, "topic": topic,
            **camera_options(camera), "fov": fov, "camera_refine": camera_refine, "timestamps": timestamps, "fps": fps,
            "settings": file, "rotate": rotate, "mask": mask, "start": seconds_text(start), "end": seconds_text(end),
            "max_frames": max_frames, "speed": speed, "distance": distance, "metric": metric, "lever_arm": lever_arm,
            "side_slip": side_slip, "fit_side_slip": fit_side_slip, "history": history, "out": out, "quiet": quiet})
    found["history"] = from_csv(found["history"])
    return Calibration(**found)


@dataclasses.dataclass(frozen=True, repr=False)
class Rescaled:
    """A trajectory in metres. Tables are structured arrays, as those of `Drive`."""

    trajectory: Table
    """time (s), x, y, z (m), qx, qy, qz, qw."""
    scale: Table
    """Per pose: pose, time (s), metres_per_unit, sigma_relative, and the same from the poses so far (filtered_...)."""
    turns: Table
    """Per turn: first_pose, last_pose, angle_deg, speed_mps, metres_per_unit, sigma_relative, smoothed_..., used, reason."""
    summary: dict[str, Any]
    """Length (m), scale, sigmas, camera rotation (degrees), side slip (s^2/m), warnings; as summary.json."""

    def __repr__(self) -> str:
        length = f"{self.summary['length_m']:.2f} m{_percent(self.summary.get('length_sigma'))}"
        return f"<Rescaled: {len(self.trajectory)} poses, {length}>"


def rescale(path: Path, *, lever_arm: float | None = None, lever_arm_sigma: float | None = None,
            heights: Path | None = None, camera_height: Height | None = None, side_slip: float | None = None,
            side_slip_sigma: float | None = None, camera_rotation: Rotation | None = None, fps: float | None = None,
            timestamps: Path | None = None, drift: Literal["auto", "none"] = "auto", out: Path | None = None,
            report: Path | None = None) -> Rescaled:
    """Converts an up-to-scale trajectory of any monocular SLAM to metres, as `turnscale rescale` does.

    path: TUM, KITTI or EuRoC file, or the folder of a run.
    lever_arm, lever_arm_sigma: distance from the rear axle forward to the camera, m.
    heights: CSV file with heights of the camera above the road: time (s), height and optionally sigma, both in
        the trajectory's unit of length; the trajectory must have times.
    camera_height: of the camera above the road, m, or (height, sigma); lever_arm is not needed then.
    side_slip, side_slip_sigma: slip-angle coefficient c, s^2/m.
    camera_rotation: "auto", "identity", (yaw, pitch, roll) in degrees, or a YAML file.
    fps, timestamps: of a KITTI trajectory; fps: also of one whose times are numbers of frames.
    drift: "none" for trajectories that are closed in loops.
    out: TUM file, report: folder to write; nothing is written without.

    Raises ValueError where the scale is not observable or the file cannot be used.
    """
    found = _native.rescale({
        "input": path, "lever_arm": lever_arm, "lever_arm_sigma": lever_arm_sigma, "heights": heights,
        "camera_height": list_text(camera_height), "side_slip": side_slip, "side_slip_sigma": side_slip_sigma,
        "camera_rotation": list_text(camera_rotation), "fps": fps, "timestamps": timestamps, "drift": drift, "out": out,
        "report": report})
    return Rescaled(trajectory=from_tum(found["tum"]), scale=from_csv(found["scale"]), turns=from_csv(found["turns"]),
                    summary=json.loads(found["summary"]))


def evaluate(estimate: Path, ground_truth: Path, *, timestamps: Path | None = None, time_tolerance: float | None = None,
             keyframes: Path | None = None, camera_rotation: Rotation | None = None, json: Path | None = None,
             picture: Path | None = None, report: Path | None = None, floor_plan: Path | None = None) -> dict[str, Any]:
    """Errors of a trajectory against ground truth, as `turnscale evaluate` computes them.

    estimate, ground_truth: TUM, EuRoC or KITTI files; estimate also the folder of a run. timestamps: times of the
    KITTI file, s.
    time_tolerance: of poses that belong together, s. keyframes: trajectory.csv of the run.
    camera_rotation: (yaw, pitch, roll) in degrees, or a YAML file.
    json, picture, report: files to write; floor_plan is drawn in them.

    Returns what `--json` writes: names end with the unit. Raises ValueError where the files cannot be used or do not fit.
    """
    return _loads(_native.evaluate({
        "estimate": estimate, "ground_truth": ground_truth, "timestamps": timestamps, "time_tolerance": time_tolerance,
        "keyframes": keyframes, "camera_rotation": list_text(camera_rotation), "json": json, "picture": picture,
        "report": report, "floor_plan": floor_plan}))


def _loads(text: bytes) -> dict[str, Any]:
    errors: dict[str, Any] = json.loads(text)
    return errors
