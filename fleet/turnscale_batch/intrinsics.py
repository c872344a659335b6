# SPDX-License-Identifier: MIT
"""Joint intrinsics of a camera from the camera.yaml of drives that have estimated them."""
import dataclasses

import numpy as np
import yaml

MOST_DEVIATION = 4  # standard deviations of a focal length from the median, beyond which it does not count


@dataclasses.dataclass
class Intrinsics:
    """Of one drive, or of several."""

    size: tuple  # pixels
    model: str
    matrix: np.ndarray  # as in the file, nine numbers
    distortion: np.ndarray
    focal_sigma: float  # pixels

    @property
    def focal(self):
        return float(self.matrix[0])

    def text(self):
        """A file for `run --camera`."""
        def row(values):
            return "[" + ", ".join(f"{value:.10g}" for value in values) + "]"
        return (f"image_width: {self.size[0]}\nimage_height: {self.size[1]}\n"
                f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: {row(self.matrix)}\ndistortion_model: {self.model}\n"
                f"distortion_coefficients:\n  rows: 1\n  cols: {len(self.distortion)}\n"
                f"  data: {row(self.distortion)}\nfocal_length_sigma: {self.focal_sigma:.6g}\n")


def read_intrinsics(path):
    """Of a camera.yaml that a run has written; None where there is none, or it has no standard deviation."""
    try:
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
        intrinsics = Intrinsics((values["image_width"], values["image_height"]), values["distortion_model"],
                                np.array(values["camera_matrix"]["data"], dtype=float),
                                np.array(values["distortion_coefficients"]["data"], dtype=float),
                                float(values["focal_length_sigma"]))
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError):
        return None
    return intrinsics if intrinsics.focal_sigma > 0 else None


def are_of_one_camera(found):
    """Whether intrinsics can be combined: they have one image size and one lens model."""
    return len({(one.size, one.model) for one in found}) <= 1


def joint_intrinsics(found):
    """Their mean, weighted by the precision of the focal length; None where there are none, or they are of different
    cameras. All numbers of a drive have one weight: focal length, principal point and distortion belong together."""
    if not found or not are_of_one_camera(found):
        return None
    centre = np.median([one.focal for one in found])
    kept = [one for one in found if abs(one.focal - centre) <= MOST_DEVIATION * one.focal_sigma]
    if not kept:
        return None
    weights = np.array([one.focal_sigma ** -2 for one in kept])
    focal = np.average([one.focal for one in kept], weights=weights)
    squared = sum(weight * (one.focal - focal) ** 2 for weight, one in zip(weights, kept))
    inflation = max(1.0, squared / (len(kept) - 1)) if len(kept) > 1 else 1.0
    return Intrinsics(kept[0].size, kept[0].model, np.average([one.matrix for one in kept], axis=0, weights=weights),
                      np.average([one.distortion for one in kept], axis=0, weights=weights),
                      float(np.sqrt(inflation / weights.sum())))
