#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plots the path and the speed of a drive.

    python3 plot_drive.py drive.mp4 --lever-arm 1.45 --out drive.png

Without matplotlib, an SVG file is written instead.
"""
from __future__ import annotations

import argparse
import importlib
import pathlib

import numpy as np
import numpy.typing as npt

import turnscale

Numbers = npt.NDArray[np.float64]


# %% The drive
def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Plots the path and the speed of a drive.")
    parser.add_argument("input", help="as for turnscale run")
    parser.add_argument("--lever-arm", type=float, help="from the rear axle forward to the camera, metres")
    parser.add_argument("--camera", help="file with the intrinsics")
    parser.add_argument("--frame-by-frame", action="store_true", help="feed the images one by one")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("drive.png"), help="picture to write")
    return parser.parse_args()


def whole_drive(given: argparse.Namespace) -> turnscale.Drive:
    return turnscale.run(given.input, camera=given.camera, lever_arm=given.lever_arm)


def frame_by_frame(given: argparse.Namespace) -> turnscale.Drive:
    frames = turnscale.Frames(given.input, camera=given.camera)
    camera = frames.camera
    if camera is None:
        raise SystemExit("the intrinsics are needed: give --camera FILE")
    odometry = turnscale.Odometry(camera, lever_arm=given.lever_arm)
    metric = False
    for frame in frames:
        result = odometry.process(frame.image, frame.time)
        if result.metric and not metric:
            print(f"frame {result.frame}: metres known to {100 * result.sigma:.1f} %")
        metric = result.metric
    return odometry.finish()


# %% The picture
def polyline(x: Numbers, y: Numbers, left: float, top: float, width: float, height: float, equal: bool) -> str:
    """A curve in a box of an SVG file."""
    x_span, y_span = max(float(np.ptp(x)), 1e-9), max(float(np.ptp(y)), 1e-9)
    across, up = width / x_span, height / y_span
    if equal:
        across = up = min(across, up)
    points = zip(left + (x - x.min()) * across, top + height - (y - y.min()) * up)
    text = " ".join(f"{a:.1f},{b:.1f}" for a, b in points)
    return f'<polyline points="{text}" fill="none" stroke="#1565c0" stroke-width="1.5"/>'


def draw_svg(path: pathlib.Path, x: Numbers, z: Numbers, time: Numbers, speed: Numbers, unit: str) -> None:
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="680" height="720" font-family="sans-serif" font-size="14">',
             '<rect width="680" height="720" fill="white"/>',
             f'<text x="20" y="24">path from above, {np.ptp(x):.0f} x {np.ptp(z):.0f} {unit}</text>',
             polyline(x, z, 20, 40, 640, 400, equal=True)]
    if len(speed):
        parts += [f'<text x="20" y="484">speed, {speed.min():.1f} to {speed.max():.1f} m/s, over {np.ptp(time):.0f} s</text>',
                  polyline(time, speed, 20, 500, 640, 200, equal=False)]
    path.write_text("\n".join([*parts, "</svg>\n"]))


def draw(path: pathlib.Path, drive: turnscale.Drive) -> pathlib.Path:
    placed = drive.trajectory[~np.isnan(drive.trajectory["x"])]
    x, z = placed["x"], placed["z"]
    time, speed, sigma = (drive.speed[name] for name in ("time", "speed_mps", "sigma_mps"))
    unit = "m" if len(drive.scale) else "units"
    try:
        pyplot = importlib.import_module("matplotlib.pyplot")
    except ImportError:
        path = path.with_suffix(".svg")
        draw_svg(path, x, z, time, speed, unit)
        return path
    pyplot.switch_backend("Agg")
    figure, (path_axes, speed_axes) = pyplot.subplots(2, 1, figsize=(7, 8), height_ratios=[2, 1])
    path_axes.plot(x, z)
    path_axes.set(xlabel=f"x [{unit}]", ylabel=f"z [{unit}]", title="path from above", aspect="equal")
    speed_axes.plot(time, speed)
    speed_axes.fill_between(time, speed - sigma, speed + sigma, alpha=0.3, label="1 sigma")
    speed_axes.set(xlabel="time [s]", ylabel="speed [m/s]")
    figure.tight_layout()
    figure.savefig(path)
    return path


def main() -> None:
    given = arguments()
    drive = frame_by_frame(given) if given.frame_by_frame else whole_drive(given)
    for turn in drive.turns:
        print(f"turn of {turn['angle_deg']:.0f} deg, frames {turn['first_frame']} to {turn['last_frame']}:",
              f"{turn['metres_per_unit']:.4g} m per unit" if turn["used"] else f"not used: {turn['reason']}")
    print(f"picture: {draw(given.out, drive)}")


if __name__ == "__main__":
    main()
