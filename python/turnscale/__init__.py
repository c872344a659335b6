# SPDX-License-Identifier: MIT
"""Monocular visual odometry for cars, in metres.

    import turnscale
    drive = turnscale.run("drive.mp4", lever_arm=1.45)
    drive.trajectory["x"]                        # metres, one value per frame
    pandas.DataFrame(drive.speed)

    odometry = turnscale.Odometry("camera.yaml", lever_arm=1.45)
    for image, time in camera:                   # uint8 of shape (height, width), seconds
        result = odometry.process(image, time)
        if result.metric:
            print(result.pose, result.sigma)
    drive = odometry.finish()

Options have the names of the program's, `turnscale run --help`. What cannot be used raises ValueError, a failure of
turnscale or of the machine RuntimeError, each with the line that the program prints.

Axes are x right, y down, z forward. The world is the first keyframe's camera frame. Sigmas are standard deviations
(1 sigma).
"""
from turnscale._commands import Calibration, Drive, Frames, Rescaled, calibrate, evaluate, read, rescale, run
from turnscale._native import Camera, Frame, FrameResult, __version__
from turnscale._odometry import Odometry

__all__ = ["Calibration", "Camera", "Drive", "Frame", "FrameResult", "Frames", "Odometry", "Rescaled", "__version__",
           "calibrate", "evaluate", "read", "rescale", "run"]
