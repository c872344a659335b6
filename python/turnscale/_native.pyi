# SPDX-License-Identifier: MIT
from collections.abc import Iterator, Sequence
from typing import Any, Final, TypedDict

import numpy as np
import numpy.typing as npt

from turnscale._options import Path

__version__: Final[str]

class Camera:
    """A calibrated camera: intrinsics in pixels, lens model and image size.

    fx, fy, cx, cy: focal lengths and principal point, pixels; pixel centres are at integers.
    width, height: image size, pixels; 0: that of the first image.
    distortion: k1 k2 p1 p2 k3 of the lens 'radial-tangential' (OpenCV, Kalibr's radtan), or
    k1 k2 k3 k4 of 'equidistant' (OpenCV's fisheye).
    lens: 'pinhole', 'radial-tangential' or 'equidistant'.

    Raises ValueError where the camera makes no sense.
    """

    def __init__(self, fx: float, fy: float, cx: float, cy: float, *, width: int = 0, height: int = 0,
                 distortion: Sequence[float] = ..., lens: str = "radial-tangential") -> None: ...
    @staticmethod
    def read(path: Path) -> Camera:
        """Reads a calibration: KITTI calib.txt, OpenCV, ORB-SLAM or Kalibr YAML."""
    @property
    def fx(self) -> float:
        """Pixels."""
    @property
    def fy(self) -> float:
        """Pixels."""
    @property
    def cx(self) -> float:
        """Pixels."""
    @property
    def cy(self) -> float:
        """Pixels."""
    @property
    def width(self) -> int:
        """Pixels; 0 if not known."""
    @property
    def height(self) -> int:
        """Pixels; 0 if not known."""
    @property
    def distortion(self) -> tuple[float, float, float, float, float]:
        """In the lens model's order, filled with zeros to five."""
    @property
    def lens(self) -> str: ...
    def __eq__(self, other: object) -> bool: ...

class FrameResult:
    """What the odometry says of a frame when it has seen it."""

    @property
    def frame(self) -> int:
        """Number of the frame, from 0."""
    @property
    def time(self) -> float:
        """Seconds."""
    @property
    def state(self) -> str:
        """'initializing', 'tracked', 'repeated', 'bridged' or 'unreadable'."""
    @property
    def pose(self) -> npt.NDArray[np.float64] | None:
        """world_from_camera as float64 of shape (4, 4): camera to world, axes x right, y down, z
        forward. In metres if `metric`, else in the map's unit. None while there is no map."""
    @property
    def metric(self) -> bool:
        """Whether the pose is in metres."""
    @property
    def scale_state(self) -> str:
        """'pending', 'observed', 'held' or 'road'."""
    @property
    def scale(self) -> float:
        """Metres per unit of the map at the last keyframe; NaN while pending."""
    @property
    def sigma(self) -> float:
        """Relative standard deviation of the scale; inf while pending."""
    @property
    def keyframe(self) -> bool: ...
    @property
    def tracked(self) -> int:
        """Features tracked into this frame."""
    @property
    def inliers(self) -> int:
        """Landmarks that agree with the pose."""
    @property
    def psi_deg(self) -> float:
        """Turning angle since the last keyframe, degrees; NaN unless a keyframe."""
    @property
    def theta_deg(self) -> float:
        """Direction of travel, degrees; NaN unless a keyframe."""
    @property
    def turning(self) -> bool:
        """The step to the frame's keyframe belongs to a turn."""
    @property
    def vehicle_from_camera(self) -> npt.NDArray[np.float64]:
        """Camera-to-vehicle rotation as far as it is known, float64 of shape (3, 3)."""

class Frame:
    """An image of a drive."""

    @property
    def index(self) -> int:
        """From 0 at the first one read."""
    @property
    def time(self) -> float:
        """Seconds."""
    @property
    def image(self) -> npt.NDArray[np.uint8] | None:
        """Gray pixels, uint8 of shape (height, width); None where the image is unusable."""
    @property
    def problem(self) -> str:
        """Why there is no image; empty if there is."""
    @property
    def notice(self) -> str:
        """What to know before this frame, such as a gap; may be empty."""

class Tables:
    @property
    def trajectory(self) -> str: ...
    @property
    def turns(self) -> str: ...
    @property
    def speed(self) -> str: ...
    @property
    def scale(self) -> str: ...
    @property
    def camera_rotation(self) -> str: ...
    @property
    def live(self) -> str: ...
    @property
    def summary(self) -> bytes: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def landmarks(self) -> npt.NDArray[np.float32]: ...
    @property
    def cameras(self) -> npt.NDArray[np.float64]: ...

class FrameByFrame:
    def __init__(self, camera: Camera, options: dict[str, Any]) -> None: ...
    def set_mask(self, mask: npt.NDArray[np.uint8]) -> None: ...
    def process(self, image: npt.NDArray[np.uint8], time: float) -> FrameResult: ...
    def process_unreadable(self, time: float) -> FrameResult: ...
    def finish(self) -> None: ...
    def tables(self) -> Tables: ...
    @property
    def camera(self) -> Camera: ...
    @property
    def scale_state(self) -> str: ...
    @property
    def frames(self) -> int: ...

class DriveReader(Iterator[Frame]):
    def __init__(self, options: dict[str, Any]) -> None: ...
    def __next__(self) -> Frame: ...
    @property
    def expected(self) -> int: ...
    @property
    def camera(self) -> Camera | None: ...

class _Rescaled(TypedDict):
    tum: str
    scale: str
    turns: str
    summary: bytes

def run(options: dict[str, Any], keeps_folder: bool) -> None: ...
def calibrate(options: dict[str, Any]) -> dict[str, Any]: ...
def rescale(options: dict[str, Any]) -> _Rescaled: ...
def evaluate(options: dict[str, Any]) -> bytes: ...
def headers() -> dict[str, str]: ...
