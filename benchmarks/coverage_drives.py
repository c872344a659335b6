# SPDX-License-Identifier: MIT
"""The rendered drives on which stated sigmas are tested: different worlds, cars and cameras."""
import dataclasses
import math
import random
import statistics

from runs import HALF_SIZE_CAMERA

# The cars, spread evenly over these and dealt out to the drives.
LEVER_ARMS = (0.9, 2.2)  # metres
SIDE_SLIPS = (0.002, 0.008)  # s^2/m, where it is given
USUAL_SIDE_SLIP = statistics.NormalDist(0.0045, 0.002)  # s^2/m, what a run takes for granted where it is not
LEAST_SIDE_SLIP = 0.0005
DEGREES_PER_G = 180 / math.pi * 9.81  # of slip, for a side slip of 1 s^2/m
# Of the drives that differ in more than the car:
SIDEWAYS = (1.0, 4.5)  # m/s^2, the most that the driver takes
CAMERA_TURNED = 4  # degrees of yaw and pitch, to either side
GARAGE_SECONDS, STREET_SECONDS = 30, 45
GARAGE_SEEDS = range(101, 119)
# Streets on which these cars turn twice or more in this time.
STREET_SEEDS = [202, 203, 205, 207, 208, 209, 210, 212, 213, 214, 215, 216, 217, 218, 220, 221, 222, 223]
GARAGES, STREETS, OTHERS = 14, 14, 8


@dataclasses.dataclass
class Errors:
    """Errors of what a run is given, in sigmas."""
    lever_arm: float
    side_slip: float | None  # None: not given
    height: float


@dataclasses.dataclass
class Drive:
    name: str
    arguments: list  # of simulate
    rig: dict
    errors: list  # Errors of each of its runs


def spread(limits, count, draw):
    """Numbers in the limits, one in each of as many equal parts, in any order."""
    low, high = limits
    numbers = [low + (high - low) * (i + draw.random()) / count for i in range(count)]
    draw.shuffle(numbers)
    return numbers


def spread_normal(count, draw, normal=statistics.NormalDist()):
    """Numbers of a normal distribution, one in each of as many equally likely parts, in any order."""
    return [normal.inv_cdf(share) for share in spread((0, 1), count, draw)]


def draw_errors(given, draw):
    """The errors of one run of each drive: of the lever arm, the side slip where it is given, and the height."""
    lever_arms, heights = (spread_normal(len(given), draw) for _ in range(2))
    side_slips = iter(spread_normal(sum(given), draw))
    return [Errors(arm, next(side_slips) if slip_given else None, height)
            for arm, height, slip_given in zip(lever_arms, heights, given)]


def make_drives(runs=1):
    draw = random.Random(36)
    count = GARAGES + STREETS + OTHERS
    lever_arms, side_slips = spread(LEVER_ARMS, count, draw), spread(SIDE_SLIPS, count, draw)
    sideways = spread(SIDEWAYS, OTHERS, draw)
    yaws, pitches = (spread((-CAMERA_TURNED, CAMERA_TURNED), OTHERS, draw) for _ in range(2))
    given = [i // 2 % 2 == 1 for i in range(count)]
    lever_arm_draws = spread_normal(count, draw)
    side_slip_draws = iter(spread_normal(sum(given), draw))
    usual_side_slips = iter(spread_normal(count - sum(given), draw, USUAL_SIDE_SLIP))
    height_draws = spread_normal(count, draw)
    later_errors = [draw_errors(given, random.Random(f"errors of run {run}")) for run in range(1, runs)]
    garage_seeds, street_seeds = iter(GARAGE_SEEDS), iter(STREET_SEEDS)
    drives = []
    for i in range(count):
        other = i - GARAGES - STREETS
        is_garage = i < GARAGES if other < 0 else other % 2 == 0
        seed = next(garage_seeds if is_garage else street_seeds)
        mount = {"lever_arm": round(lever_arms[i], 3)}
        side_slip = side_slips[i] if given[i] else max(LEAST_SIDE_SLIP, next(usual_side_slips))
        vehicle = {"slip_deg_per_g": round(side_slip * DEGREES_PER_G, 3)}
        if other >= 0:
            mount |= {"yaw_deg": round(yaws[other], 2), "pitch_deg": round(pitches[other], 2)}
            vehicle["max_lateral_acceleration"] = round(sideways[other], 2)
        world, seconds = ("garage", GARAGE_SECONDS) if is_garage else ("street", STREET_SECONDS)
        drives.append(Drive(
            f"{world}_{seed}", [world, "--seed", seed, "--seconds", seconds],
            {"camera": HALF_SIZE_CAMERA, "mount": mount, "vehicle": vehicle},
            [Errors(lever_arm_draws[i], next(side_slip_draws) if given[i] else None, height_draws[i]),
             *(errors[i] for errors in later_errors)]))
    return drives
