# SPDX-License-Identifier: MIT
"""Made-up trajectories along motorways, for turnscale simulate --follow: a slip road with one tight turn, then 5 km of wide
bends over grades and crests."""
import dataclasses
import math
import random

RATE = 10  # poses per second
STEP = 0.05  # metres, of the integration along the way
CAMERA_FORWARD = 0.945  # metres ahead of the rear axle, as in the rig kitti
LENGTH = 5000  # metres on the motorway
SPEEDS = (26, 30)  # m/s
RADII = (400, 2000)  # metres
ACCELERATION = 1.3  # m/s^2
GRADE = 0.02  # the most
GRADE_LENGTHS = (350, 900)  # metres from a crest to the next dip
SLIP_ROAD_TRANSITION, TRANSITION = 12, 70  # metres in which the curvature changes


@dataclasses.dataclass
class SlipRoad:
    radius: float  # metres
    angle_deg: float  # positive to the right
    speed: float  # m/s


# By seed.
SLIP_ROADS = {1: SlipRoad(30, 120, 8.5), 2: SlipRoad(34, -150, 9.5)}


def bends(draw):
    """(metres, curvature, speed) of a motorway's parts: to the left and to the right by turns, some straights."""
    side, heading, driven = draw.choice((-1, 1)), 0, 0
    while driven < LENGTH:
        speed = draw.uniform(*SPEEDS)
        if draw.random() < 0.25:
            length, curvature = draw.uniform(300, 700), 0
        else:
            radius = math.exp(draw.uniform(*map(math.log, RADII)))
            wanted = side * draw.uniform(0.2, 0.45)
            length, curvature = radius * abs(wanted - heading), math.copysign(1 / radius, wanted - heading)
            heading, side = wanted, -side
        length = min(length, LENGTH - driven)
        driven += length
        yield length, curvature, speed


def grades(length, draw):
    """(metres, grade): crests and dips, between which the grade changes evenly."""
    points, at, side = [(0, 0)], 200, draw.choice((-1, 1))
    while at < length:
        points.append((at, side * draw.uniform(0.3, 1) * GRADE))
        at += draw.uniform(*GRADE_LENGTHS)
        side = -side
    return [*points, (at, 0)]


def between(points, at):
    for (start, a), (end, b) in zip(points, points[1:]):
        if at < end:
            return a + (b - a) * (at - start) / (end - start)
    return points[-1][1]


def trajectory(seed):
    """The camera's poses in the frame of the first one, TUM format."""
    draw, slip = random.Random(seed), SLIP_ROADS[seed]
    arc = slip.radius * math.radians(abs(slip.angle_deg))
    parts = [(40, 0, slip.speed), (arc, math.copysign(1 / slip.radius, slip.angle_deg), slip.speed), (40, 0, slip.speed),
             *bends(draw)]
    slopes = grades(sum(length for length, _, _ in parts), draw)
    x = z = up = heading = time = metres = curvature = 0
    speed = slip.speed
    lines = []
    for number, (length, wanted, wanted_speed) in enumerate(parts):
        before, done = curvature, 0
        while done < length:
            if time >= len(lines) / RATE - 1e-9:
                lines.append(pose_line(time, x, up, z, heading))
            curvature = before + (wanted - before) * min(1, done / (SLIP_ROAD_TRANSITION if number < 3 else TRANSITION))
            change = ACCELERATION * STEP / speed
            speed += max(-change, min(change, wanted_speed - speed))
            heading += STEP * curvature
            x += STEP * math.sin(heading)
            z += STEP * math.cos(heading)
            up += STEP * between(slopes, metres)
            time += STEP / speed
            metres += STEP
            done += STEP
    return "".join(lines)


def pose_line(time, x, up, z, heading):
    """Of a rear axle at (x, -up, z)."""
    sine, cosine = math.sin(heading), math.cos(heading)
    values = (x + CAMERA_FORWARD * sine, -up, z + CAMERA_FORWARD * (cosine - 1), 0, math.sin(heading / 2), 0,
              math.cos(heading / 2))
    return f"{time:.6f} " + " ".join(f"{value:.9f}" for value in values) + "\n"
