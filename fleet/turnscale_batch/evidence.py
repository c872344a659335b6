# SPDX-License-Identifier: MIT
"""What one drive tells of its car, without what was known before it."""
import dataclasses
import math

import numpy as np

from .intrinsics import read_intrinsics

# Unknowns of a drive: yaw of the camera (rad), c (s^2/m), ln of lever arm and of camera height (metres).
YAW, SLIP, ARM, HEIGHT = range(4)
UNKNOWNS = 4

# Standard deviations of what changes between drives of one car: load and tyres. All but that of the slip are what
# `run --vehicle` adds by itself.
YAW_BETWEEN = math.radians(0.1)
HEIGHT_BETWEEN = 0.01  # relative
SLIP_BETWEEN = 0.12  # relative, as for --side-slip
# Grade and load turn the camera against the direction of travel.
PITCH_BETWEEN = math.radians(0.4)
ROLL_BETWEEN = math.radians(0.5)
USUAL_SLIP = 0.0045  # s^2/m


@dataclasses.dataclass
class Evidence:
    """Information matrix and vector (information times mean) of a drive's likelihood, and the prior that it was read
    with. Yaw is that of the camera, not its error."""

    information: np.ndarray
    vector: np.ndarray
    prior_mean: np.ndarray
    prior_covariance: np.ndarray

    def of_car(self, slip=USUAL_SLIP):
        """Information on the car's constants, from which the drive's own differ by what changes between drives."""
        between = np.diag([YAW_BETWEEN, SLIP_BETWEEN * slip, 0, HEIGHT_BETWEEN]) ** 2
        spread = np.linalg.inv(np.eye(UNKNOWNS) + self.information @ between)
        information = spread @ self.information
        return 0.5 * (information + information.T), spread @ self.vector


@dataclasses.dataclass
class Rotation:
    """Of the camera, as found by a drive: yaw, pitch, roll and their standard deviations, rad."""

    angles: np.ndarray
    sigmas: np.ndarray


@dataclasses.dataclass
class DriveEstimates:
    """Of a drive's first pass; each part is None where the drive does not tell it."""

    drive: object
    evidence: Evidence | None = None
    rotation: Rotation | None = None
    intrinsics: object = None  # where they were estimated
    calibrated: bool = True  # they were given
    has_arm: bool = False  # a lever arm was given
    moved: bool = False  # the camera was, during the drive


def _evidence(summary):
    told = summary.get("car_evidence")
    if not told:
        return None
    prior, posterior = told["prior"], told["posterior"]
    prior_covariance = np.array(prior["covariance"], dtype=float)
    before = np.linalg.inv(prior_covariance)
    before_vector = before @ np.array(prior["mean"], dtype=float)
    after = np.linalg.inv(np.array(posterior["covariance"], dtype=float))
    if (summary.get("camera_rotation") or {}).get("source") == "found":
        # The rotation, and with it the prior of its error, is of the drive's own images.
        before[YAW, YAW] = 0
        before_vector[YAW] = 0
    inflation = told.get("inflation", 1.0) ** 2
    information = (after - before) / inflation
    vector = (after @ np.array(posterior["mean"], dtype=float) - before_vector) / inflation
    prior_mean = np.array(prior["mean"], dtype=float)
    # From the error of the yaw to the yaw.
    yaw = math.radians(summary["camera_yaw_pitch_roll_deg"][0])
    vector = vector + information[:, YAW] * yaw
    prior_mean[YAW] += yaw
    if not (np.isfinite(information).all() and np.isfinite(vector).all()):
        return None
    return Evidence(_positive(information), vector, prior_mean, prior_covariance)


def _positive(information):
    """Without the negative eigenvalues that rounding leaves where the drive tells nothing."""
    scale = np.array([math.radians(0.3), 0.002, 0.02, 0.1])
    values, vectors = np.linalg.eigh(0.5 * (information + information.T) * np.outer(scale, scale))
    return vectors @ np.diag(np.maximum(values, 0)) @ vectors.T / np.outer(scale, scale)


def estimates_of(drive, summary, folder):
    """From the results of a drive's first pass."""
    found = summary.get("camera_rotation") or {}
    rotation = None
    if found.get("source") == "found":
        rotation = Rotation(np.radians(summary["camera_yaw_pitch_roll_deg"]),
                            np.radians(found["sigma_yaw_pitch_roll_deg"]))
    intrinsics = summary.get("intrinsics") or {}
    estimated = intrinsics.get("source") == "estimated" and intrinsics.get("converged")
    return DriveEstimates(drive, _evidence(summary), rotation,
                          read_intrinsics(folder / "camera.yaml") if estimated else None,
                          intrinsics.get("source") not in ("estimated", "assumed"),
                          summary.get("lever_arm_m") is not None, bool(found.get("moves")))
