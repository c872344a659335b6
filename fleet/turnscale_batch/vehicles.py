# SPDX-License-Identifier: MIT
"""The second pass: files for `run --vehicle` and `--camera` from the drives of one car, and vehicles.csv."""
import csv
import io
import math
import pathlib

import numpy as np
import yaml

from .evidence import ARM, HEIGHT, PITCH_BETWEEN, ROLL_BETWEEN, SLIP, SLIP_BETWEEN, YAW
from .intrinsics import are_of_one_camera, joint_intrinsics
from .joint import JointEstimate, camera_positions
from .store import write_whole

COLUMNS = ("vehicle", "position", "first_drive", "last_drive", "drives", "side_slip", "side_slip_sigma", "yaw_deg",
           "yaw_sigma_deg", "pitch_deg", "pitch_sigma_deg", "roll_deg", "roll_sigma_deg", "lever_arm",
           "lever_arm_sigma", "height", "height_sigma", "focal_length", "focal_length_sigma", "outliers")
MOST_YAW_SIGMA = math.radians(1)  # beyond which a rotation is not handed on
MOST_HEIGHT_SIGMA = 0.15  # relative, likewise
MOST_ARM_SIGMA = 0.9  # relative, at most: run refuses a sigma as large as the lever arm
MOST_CORRELATION = 0.98
# What the joint files hold instead.
OPTIONS_OF_SLIP = ("--side-slip", "--side-slip-sigma")
OPTIONS_OF_CAR = ("--vehicle", "--lever-arm", "--lever-arm-sigma", "--camera-height")
OPTIONS_OF_INTRINSICS = ("--camera", "--fov")
CAR_FILE, CAMERA_FILE = "joint_car.yaml", "joint_camera.yaml"
# Two drives have the same camera, as far as the manifest says, if these are equal.
OPTIONS_OF_CAMERA = ("--vehicle", "--lever-arm", "--camera", "--camera-height", "--camera-rotation", "--fov")


def _distinct(ab, ac, bc):
    """Correlations of three errors, all smaller by the same factor where a reader could not tell the errors apart."""
    least = np.linalg.eigvalsh([[0, ab, ac], [ab, 0, bc], [ac, bc, 0]])[0]
    return [MOST_CORRELATION / max(-least, MOST_CORRELATION) * value for value in (ab, ac, bc)]


def _angles(estimates, without=None):
    """Mean and standard deviation of yaw, pitch and roll that drives have found; None if there are none."""
    found = [e.rotation for e in estimates if e.rotation is not None and e is not without and not e.moved]
    if not found:
        return None
    between = np.array([0, PITCH_BETWEEN, ROLL_BETWEEN])
    weights = np.array([1 / (rotation.sigmas ** 2 + between ** 2) for rotation in found])
    values = np.array([rotation.angles for rotation in found])
    # One drive that went wrong does not count.
    centre = np.median(values, axis=0)
    weights = np.where(np.abs(values - centre) * np.sqrt(weights) > 4, 0, weights)
    total = weights.sum(axis=0)
    if not (total > 0).all():
        return centre, between + np.radians(1)
    return (weights * values).sum(axis=0) / total, 1 / np.sqrt(total)


def _line(key, value):
    return f"{key}: {value:.8g}\n"


def _image_lag(path):
    """Of the images, which are stabilised, as a file for `run --vehicle` has it: drives do not tell it jointly."""
    try:
        values = yaml.safe_load(pathlib.Path(path).read_text(encoding="utf-8")) if path else {}
        return "".join(_line(key, float(values[key])) for key in ("image_lag", "image_lag_sigma") if key in values)
    except (OSError, yaml.YAMLError, TypeError, ValueError):
        return ""  # run itself says what is wrong with the file


class Vehicle:
    """The drives of one car whose first pass has ended well."""

    def __init__(self, name, estimates):
        self.name = name
        self.estimates = list(estimates)
        self._place = {e.drive.name: i for i, e in enumerate(self.estimates)}
        self.positions = camera_positions(
            self.estimates,
            lambda a, b: all(a.drive.value(option) == b.drive.value(option) for option in OPTIONS_OF_CAMERA))
        self.joint = JointEstimate(self.positions, [e.evidence for e in self.estimates])

    def _at(self, position):
        return [e for e, place in zip(self.estimates, self.positions) if place == position]

    def doubts(self, drive):
        place = self._place.get(drive.name)
        if place is None:
            return []
        doubts = []
        if place in self.joint.outliers:
            doubts.append(f"the drive's estimates of the car differ from those of the other drives of {self.name}, and "
                          "are left out of the joint ones")
        found = [e.intrinsics for e in self._at(self.positions[place]) if e.intrinsics]
        if not self.estimates[place].calibrated and not are_of_one_camera(found):
            doubts.append(f"the drives of {self.name} have images of different sizes or lens models: their intrinsics "
                          "are not combined; give a calibration (column camera)")
        return doubts

    def joint_files(self, drive):
        """Files that hold what all drives tell, as triples of option, name and text, and the options that they
        replace."""
        i = self._place.get(drive.name)
        if i is None or i in self.joint.outliers:
            return [], ()
        files, replaced = [], []
        # A file of the drive's own says more than c alone.
        text = None if drive.option("--vehicle") and not self._knows_position(i) else self._car_file(i)
        if text is not None:
            files.append(["--vehicle", CAR_FILE, text])
            replaced += [*OPTIONS_OF_SLIP, *(OPTIONS_OF_CAR if self._knows_position(i) else [])]
        if (camera := self._camera(i)) is not None:
            files.append(["--camera", CAMERA_FILE, camera.text()])
            replaced += OPTIONS_OF_INTRINSICS
        return files, replaced

    def _knows_position(self, i):
        """Whether another drive tells of the camera where it is in drive i."""
        return any(k != i and k not in self.joint.outliers and self.positions[k] == self.positions[i] and
                   e.evidence is not None for k, e in enumerate(self.estimates))

    def _camera(self, i):
        """Intrinsics of all drives with the camera of drive i, its own included: it does not estimate them again."""
        own = self.estimates[i]
        found = [e.intrinsics for e in self._at(self.positions[i]) if e.intrinsics]
        if own.calibrated or found in ([], [own.intrinsics]):
            return None
        return joint_intrinsics(found)

    def _car_file(self, i):
        """Text of a file for `run --vehicle` with what the other drives tell; None where they tell nothing."""
        if not self.joint:
            return None
        joint = self.joint.without(i)
        if joint.drives == 0:
            return None
        text = "# What the other drives of the car tell of it.\n"
        own = self.estimates[i]
        slip = max(joint.mean[SLIP], 0.0)
        slip_sigma = math.hypot(joint.sigma(SLIP), SLIP_BETWEEN * slip)
        text += _line("side_slip", slip) + _line("side_slip_sigma", slip_sigma)
        if not self._knows_position(i):
            return text
        text += _image_lag(own.drive.option("--vehicle"))
        angles = _angles(self._at(self.positions[i]), without=own)
        if angles is not None and joint.sigma(YAW) < MOST_YAW_SIGMA and not own.moved:
            (_, pitch, roll), (_, pitch_sigma, roll_sigma) = angles
            text += _line("yaw_deg", math.degrees(joint.mean[YAW])) + _line("pitch_deg", math.degrees(pitch))
            text += _line("roll_deg", math.degrees(roll)) + _line("yaw_sigma_deg", math.degrees(joint.sigma(YAW)))
            text += _line("pitch_sigma_deg", math.degrees(pitch_sigma))
            text += _line("roll_sigma_deg", math.degrees(roll_sigma))
        has_height = joint.sigma(HEIGHT) < MOST_HEIGHT_SIGMA and not own.moved
        # What changes between drives has nothing to do with the other constants.
        slip_share = joint.sigma(SLIP) / slip_sigma
        arm_slip, height_arm, height_slip = _distinct(
            slip_share * joint.correlation(ARM, SLIP) if own.has_arm else 0.0,
            joint.correlation(HEIGHT, ARM) if own.has_arm and has_height else 0.0,
            slip_share * joint.correlation(HEIGHT, SLIP) if has_height else 0.0)
        if own.has_arm:
            arm = math.exp(joint.mean[ARM])
            text += _line("lever_arm", arm) + _line("lever_arm_sigma", min(joint.sigma(ARM), MOST_ARM_SIGMA) * arm)
            text += _line("lever_arm_slip_correlation", arm_slip)
        if has_height:
            height = math.exp(joint.mean[HEIGHT])
            text += _line("height", height) + _line("height_sigma", joint.sigma(HEIGHT) * height)
            if own.has_arm:
                text += _line("height_correlation", height_arm)
            text += _line("height_slip_correlation", height_slip)
        return text

    def rows(self):
        """Of vehicles.csv, one per position of the camera."""
        for position in sorted(set(self.positions)):
            members = self._at(position)
            row = dict.fromkeys(COLUMNS, "")
            row |= {"vehicle": self.name, "position": position + 1, "first_drive": members[0].drive.name,
                    "last_drive": members[-1].drive.name, "drives": len(members)}
            outliers = [e.drive.name for e in members if self._place[e.drive.name] in self.joint.outliers]
            row["outliers"] = " ".join(outliers)
            if self.joint:
                joint = self.joint.at(position)
                row |= {"side_slip": f"{joint.mean[SLIP]:.5f}", "side_slip_sigma": f"{joint.sigma(SLIP):.5f}"}
                if any(e.has_arm for e in members):
                    arm = math.exp(joint.mean[ARM])
                    row |= {"lever_arm": f"{arm:.4f}", "lever_arm_sigma": f"{joint.sigma(ARM) * arm:.4f}"}
                if joint.sigma(HEIGHT) < MOST_HEIGHT_SIGMA:
                    height = math.exp(joint.mean[HEIGHT])
                    row |= {"height": f"{height:.4f}", "height_sigma": f"{joint.sigma(HEIGHT) * height:.4f}"}
            if (angles := _angles(members)) is not None:
                values, sigmas = np.degrees(angles[0]), np.degrees(angles[1])
                if self.joint and joint.sigma(YAW) < MOST_YAW_SIGMA:
                    values[0], sigmas[0] = math.degrees(joint.mean[YAW]), math.degrees(joint.sigma(YAW))
                for k, name in enumerate(("yaw", "pitch", "roll")):
                    row |= {f"{name}_deg": f"{values[k]:.3f}", f"{name}_sigma_deg": f"{sigmas[k]:.3f}"}
            camera = joint_intrinsics([e.intrinsics for e in members if e.intrinsics])
            if camera is not None:
                row |= {"focal_length": f"{camera.focal:.2f}", "focal_length_sigma": f"{camera.focal_sigma:.2f}"}
            yield row


def write_vehicles(path, vehicles):
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for vehicle in vehicles:
        writer.writerows(vehicle.rows())
    write_whole(path, text.getvalue())
