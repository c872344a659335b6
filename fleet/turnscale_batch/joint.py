# SPDX-License-Identifier: MIT
"""Joint estimates of one car from the evidence of its drives.

The unknowns are c of the car and, for each position of the camera, its yaw, the lever arm and the height. Each drive
adds the information of its own likelihood; what was known before the drives counts once. An estimate for a drive leaves
its own evidence out, so that the drive can be run again with it as prior knowledge.
"""
import dataclasses
import math

import numpy as np

from .evidence import ARM, HEIGHT, PITCH_BETWEEN, SLIP, UNKNOWNS, USUAL_SLIP, YAW, YAW_BETWEEN, HEIGHT_BETWEEN

# 99.9 % quantiles of chi-squared, by degrees of freedom.
CHI_SQUARED = {1: 10.83, 2: 13.82, 3: 16.27, 4: 18.47}
# Of a yaw that nothing is known of: the camera points forward, more or less.
FLAT_YAW = math.radians(30)
# What counts as a standard deviation that tells something, of each unknown.
SCALES = np.array([math.radians(1), 0.002, 0.03, 0.1])
LEAST_INFORMATION = 0.1  # in these scales
FEWEST_FOR_OUTLIERS = 3


@dataclasses.dataclass
class Joint:
    """Mean and covariance of the four unknowns at one position, as SCALES has them in order."""

    mean: np.ndarray
    covariance: np.ndarray
    drives: int  # whose evidence is in it

    def sigma(self, unknown):
        return math.sqrt(self.covariance[unknown, unknown])

    def correlation(self, a, b):
        return self.covariance[a, b] / (self.sigma(a) * self.sigma(b))


def _of_slip(information, vector):
    """What information on the four unknowns tells of c alone."""
    place = [YAW, ARM, HEIGHT]
    solved = np.linalg.solve(information[np.ix_(place, place)],
                             np.column_stack([information[place, SLIP], vector[place]]))
    return np.array([information[SLIP, SLIP], vector[SLIP]]) - information[SLIP, place] @ solved


class JointEstimate:
    """From pairs of a position's number and a drive's Evidence (None: the drive tells nothing).

    Positions have only c in common, so that an estimate at one position needs of the others only what they tell of c. The
    estimates of n drives take a time proportional to n. `slip` is the c to which changes between drives are relative."""

    def __init__(self, positions, evidences):
        self.positions = list(positions)
        self._evidences = list(evidences)
        self.outliers = set()
        self.inflation = 1.0
        self._members = [i for i, evidence in enumerate(self._evidences) if evidence is not None]
        if not self._members:
            return
        self._set_prior()
        self._set_slip(USUAL_SLIP)
        # What changes between drives is relative to c.
        for _ in range(2):
            self._set_slip(max(self.at(0).mean[SLIP], 0.2 * USUAL_SLIP))
        self._remove_outliers()
        self._inflate()

    def __bool__(self):
        return bool(self._members)

    def _set_prior(self):
        """Each constant as known before the drives. Where drives were given different values of c, the narrowest."""
        known = [(self.positions[i], self._evidences[i]) for i in self._members]
        slip = min((evidence for _, evidence in known), key=lambda e: e.prior_covariance[SLIP, SLIP])
        self._slip_prior = np.array([1, slip.prior_mean[SLIP]]) / slip.prior_covariance[SLIP, SLIP]
        first = {}
        for position, evidence in known:
            first.setdefault(position, evidence)
        count = max(self.positions) + 1
        self._prior_information, self._prior_vector = np.zeros((count, UNKNOWNS, UNKNOWNS)), np.zeros((count, UNKNOWNS))
        lengths = np.ix_([ARM, HEIGHT], [ARM, HEIGHT])
        for position in range(count):
            before = first.get(position, slip)
            information = self._prior_information[position]
            information[lengths] = np.linalg.inv(before.prior_covariance[lengths])
            information[YAW, YAW] = 1 / FLAT_YAW ** 2
            self._prior_vector[position] = information @ before.prior_mean

    def _set_slip(self, slip):
        self.slip = slip
        self._of_drive = {i: self._evidences[i].of_car(slip) for i in self._members}
        self._add_up()

    def _add_up(self):
        """Information and vector of each position, and what each tells of c."""
        self._information, self._vector = self._prior_information.copy(), self._prior_vector.copy()
        for i in self._members:
            information, vector = self._told(i)
            self._information[self.positions[i]] += information
            self._vector[self.positions[i]] += vector
        self._slip = np.array([_of_slip(*told) for told in zip(self._information, self._vector)])
        self._slip_of_all = self._slip_prior + self._slip.sum(axis=0)

    def _told(self, i):
        """Information and vector of drive i on the car's constants."""
        information, vector = self._of_drive[i]
        return information / self.inflation ** 2, vector / self.inflation ** 2

    def _joint(self, position, information, vector, drives):
        elsewhere = self._slip_of_all - self._slip[position]
        information[SLIP, SLIP] += elsewhere[0]
        vector[SLIP] += elsewhere[1]
        covariance = np.linalg.inv(information)
        return Joint(covariance @ vector, covariance, drives)

    def at(self, position):
        """The four unknowns at a position, from all drives."""
        return self._joint(position, self._information[position].copy(), self._vector[position].copy(),
                           len(self._members))

    def without(self, i):
        """The four unknowns for drive i, without its own evidence."""
        position = self.positions[i]
        if i not in self._of_drive:
            return self.at(position)
        information, vector = self._told(i)
        return self._joint(position, self._information[position] - information, self._vector[position] - vector,
                           len(self._members) - 1)

    def deviation(self, i):
        """Squared, of what drive i tells from what the others do, with its degrees of freedom."""
        others = self.without(i)
        information, vector = self._told(i)
        innovation = (vector - information @ others.mean) * SCALES
        scaled = information * np.outer(SCALES, SCALES)
        variance = scaled + scaled @ (others.covariance / np.outer(SCALES, SCALES)) @ scaled
        values, vectors = np.linalg.eigh(scaled)
        kept = vectors[:, values > LEAST_INFORMATION]
        if kept.shape[1] == 0:
            return 0.0, 0
        projected = kept.T @ innovation
        return float(projected @ np.linalg.solve(kept.T @ variance @ kept, projected)), kept.shape[1]

    def _remove_outliers(self):
        while len(self._members) >= FEWEST_FOR_OUTLIERS:
            deviations = {i: self.deviation(i) for i in self._members}
            excess = {i: squared / CHI_SQUARED[count] for i, (squared, count) in deviations.items() if count}
            if not excess:
                return
            worst = max(excess, key=excess.get)
            if excess[worst] <= 1:
                return
            self._members.remove(worst)
            del self._of_drive[worst]
            self.outliers.add(worst)
            self._add_up()

    def _inflate(self):
        """Drives that differ from each other by more than their standard deviations widen these."""
        if len(self._members) < 2:
            return
        deviations = [self.deviation(i) for i in self._members]
        count = sum(number for _, number in deviations)
        if count:
            self.inflation = max(1.0, math.sqrt(sum(squared for squared, _ in deviations) / count))
            self._add_up()


class _Place:
    """Where the camera sits, as the drives so far have it: yaw, pitch and ln height, each with its variance."""

    def __init__(self):
        self._weights = np.zeros(3)
        self._sums = np.zeros(3)

    def add(self, values, variances):
        weights = np.where(np.isfinite(variances), 1 / variances, 0)
        self._weights += weights
        self._sums += np.where(weights > 0, weights * values, 0)

    def squared_distance(self, values, variances):
        """With its degrees of freedom."""
        both = (self._weights > 0) & np.isfinite(variances)
        if not both.any():
            return 0.0, 0
        difference = values[both] - self._sums[both] / self._weights[both]
        return float((difference ** 2 / (1 / self._weights[both] + variances[both])).sum()), int(both.sum())

    def fits(self, values, variances):
        squared, count = self.squared_distance(values, variances)
        return count == 0 or squared <= CHI_SQUARED[count]


def _seen_place(estimates, slip):
    """Yaw, pitch, ln height of a drive and their variances, infinite where it does not tell them. The height is that
    for this c and the lever arm as given, whose errors are common to all drives."""
    values, variances = np.zeros(3), np.full(3, np.inf)
    rotation, evidence = estimates.rotation, estimates.evidence
    if rotation is not None:
        values[:2] = rotation.angles[:2]
        variances[:2] = rotation.sigmas[:2] ** 2 + np.array([YAW_BETWEEN, PITCH_BETWEEN]) ** 2
    if evidence is not None:
        free, fixed = [YAW, HEIGHT], [SLIP, ARM]
        information = evidence.information[np.ix_(free, free)] + np.diag([1 / FLAT_YAW ** 2, 1e-3])
        vector = evidence.vector[free] - evidence.information[np.ix_(free, fixed)] @ np.array(
            [slip, evidence.prior_mean[ARM]])
        vector[0] += evidence.prior_mean[YAW] / FLAT_YAW ** 2
        covariance = np.linalg.inv(information)
        if covariance[1, 1] < 0.1 ** 2:
            values[2] = (covariance @ vector)[1]
            variances[2] = covariance[1, 1] + HEIGHT_BETWEEN ** 2
    return values, variances


def camera_positions(drives, same):
    """Numbers of the camera's positions for drives (DriveEstimates) in the order of time. `same(a, b)`: whether two
    drives were given the same camera. A drive that differs from those before it begins a new position, unless the one
    after it is back at the old: then it is an outlier."""
    if not drives:
        return []
    alone = JointEstimate(range(len(drives)), [drive.evidence for drive in drives])
    slip = alone.at(0).mean[SLIP] if alone else USUAL_SLIP
    seen = [_seen_place(drive, slip) for drive in drives]
    told = [np.isfinite(variances).any() for _, variances in seen]
    positions, place, number = [], _Place(), 0
    for i, drive in enumerate(drives):
        begins = i > 0 and (not same(drives[i - 1], drive) or drive.moved or drives[i - 1].moved)
        outlier = False
        if not begins and not place.fits(*seen[i]):
            after = next((k for k in range(i + 1, len(drives)) if told[k]), None)
            outlier = after is not None and place.fits(*seen[after])
            begins = not outlier
        if begins:
            place, number = _Place(), number + 1
        if not outlier:
            place.add(*seen[i])
        positions.append(number)
    return positions
