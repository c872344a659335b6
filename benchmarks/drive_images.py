# SPDX-License-Identifier: MIT
"""Images of drives, for benchmarks that change them. Needs OpenCV for Python."""
import cv2
import numpy


def images_of(drive):
    """Its images, 8 bit, gray."""
    video = drive / "video.mkv"
    if not video.is_file():
        for path in sorted((drive / "image_0").glob("*.png")):
            yield cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        return
    capture = cv2.VideoCapture(str(video))
    while True:
        good, image = capture.read()
        if not good:
            return
        yield cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)


def pinhole_of(drive):
    """3x3, of its KITTI calibration."""
    _, *numbers = (drive / "calib.txt").read_text().split()[:13]
    return numpy.array(numbers, float).reshape(3, 4)[:, :3]
