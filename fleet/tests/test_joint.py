# SPDX-License-Identifier: MIT
"""Joint estimates of synthetic drives whose car is known."""
import math
import pathlib
import tempfile
import unittest

import numpy as np

from turnscale_batch.evidence import (ARM, HEIGHT, HEIGHT_BETWEEN, SLIP, SLIP_BETWEEN, UNKNOWNS, YAW, YAW_BETWEEN,
                                      DriveEstimates, Evidence, Rotation, estimates_of)
from turnscale_batch.intrinsics import Intrinsics
from turnscale_batch.joint import JointEstimate, camera_positions
from turnscale_batch.manifest import Drive
from turnscale_batch.vehicles import Vehicle

TAPE = 0.02  # relative
PRIOR_MEAN = np.array([0.0, 0.0045, math.log(1.5), math.log(1.4)])
PRIOR = np.diag([math.radians(3), 0.002, TAPE, 1.0]) ** 2


def random_car(draw):
    return PRIOR_MEAN + np.sqrt(np.diag(PRIOR)) * draw.standard_normal(UNKNOWNS) * [1, 1, 1, 0.1]


def posterior_of(information, vector, prior_mean=PRIOR_MEAN, prior=PRIOR):
    before = np.linalg.inv(prior)
    covariance = np.linalg.inv(before + information)
    return covariance @ (before @ prior_mean + vector), covariance


def random_likelihood(truth, draw, measurements=3, slip=0.0045):
    """Measurements, each of a random mixture of the unknowns: the drive's own constants differ from the car's."""
    own = truth + draw.standard_normal(UNKNOWNS) * [YAW_BETWEEN, SLIP_BETWEEN * slip, 0, HEIGHT_BETWEEN]
    rows = draw.standard_normal((measurements, UNKNOWNS)) / [math.radians(0.5), 0.0015, 0.05, 0.03]
    # Turns do not tell the lever arm by itself: it goes with the height.
    rows[:, ARM] = -rows[:, HEIGHT]
    read = rows @ own + draw.standard_normal(measurements)
    return rows.T @ rows, rows.T @ read


def evidence_of(information, vector):
    return Evidence(information, vector, PRIOR_MEAN.copy(), PRIOR.copy())


def summary_of(mean, covariance, source="assumed", yaw=0.0, inflation=1.0):
    """As `run` writes it."""
    return {"car_evidence": {"prior": {"mean": PRIOR_MEAN.tolist(), "covariance": PRIOR.tolist()},
                             "posterior": {"mean": mean.tolist(), "covariance": covariance.tolist()},
                             "inflation": inflation},
            "camera_rotation": {"source": source, "sigma_yaw_pitch_roll_deg": [0.2, 0.2, 1], "moves": []},
            "camera_yaw_pitch_roll_deg": [yaw, 0, 0], "lever_arm_m": 1.5}


class Prior(unittest.TestCase):
    def test_is_removed_from_what_a_run_states(self):
        draw = np.random.default_rng(1)
        information, vector = random_likelihood(random_car(draw), draw)
        summary = summary_of(*posterior_of(information, vector))
        evidence = estimates_of(None, summary, None).evidence
        scale = np.abs(information).max()
        np.testing.assert_allclose(evidence.information / scale, information / scale, atol=1e-9)
        np.testing.assert_allclose(evidence.vector / np.abs(vector).max(), vector / np.abs(vector).max(), atol=1e-9)

    def test_a_camera_that_was_moved_is_known(self):
        summary = summary_of(PRIOR_MEAN, PRIOR, source="found")
        self.assertFalse(estimates_of(None, summary, None).moved)
        summary["camera_rotation"]["moves"] = [{"time_s": 12.5, "yaw_deg": 0.1, "pitch_deg": -3.0}]
        self.assertTrue(estimates_of(None, summary, None).moved)

    def test_of_a_drive_that_tells_nothing_leaves_nothing(self):
        summary = summary_of(PRIOR_MEAN, PRIOR)
        evidence = estimates_of(None, summary, None).evidence
        joint = JointEstimate([0] * 50, [evidence] * 50).at(0)
        self.assertAlmostEqual(joint.sigma(SLIP), 0.002, places=6)
        self.assertAlmostEqual(joint.sigma(ARM), TAPE, places=6)

    def test_counts_once_in_many_drives(self):
        draw = np.random.default_rng(2)
        truth = random_car(draw)
        evidences = [evidence_of(*random_likelihood(truth, draw)) for _ in range(8)]
        joint = JointEstimate([0] * 8, evidences)
        # By hand: all information and one prior.
        information, vector = np.linalg.inv(PRIOR), np.linalg.inv(PRIOR) @ PRIOR_MEAN
        information[YAW, YAW] = vector[YAW] = 0
        for evidence in evidences:
            of_car, its_vector = evidence.of_car(max(joint.at(0).mean[SLIP], 0.2 * 0.0045))
            information, vector = information + of_car, vector + its_vector
        if joint.inflation == 1 and not joint.outliers:
            np.testing.assert_allclose(joint.at(0).mean, np.linalg.solve(information, vector), rtol=1e-2, atol=1e-3)

    def test_of_a_yaw_that_the_drive_has_found_is_the_drives(self):
        information = np.diag([0, 1 / 0.001 ** 2, 0, 0])
        vector = information @ np.array([0, 0.006, 0, 0])
        summary = summary_of(*posterior_of(information, vector), source="found", yaw=2.0)
        evidence = estimates_of(None, summary, None).evidence
        self.assertAlmostEqual(evidence.information[YAW, YAW], 1 / math.radians(3) ** 2, delta=1)
        self.assertAlmostEqual(evidence.vector[YAW] / evidence.information[YAW, YAW], math.radians(2), places=6)


class HonestSigma(unittest.TestCase):
    def deviations(self, drives, seeds, spoil=None):
        """Errors of the leave-one-out estimates over their standard deviations, each unknown in a column."""
        rows = []
        for seed in range(seeds):
            draw = np.random.default_rng(seed)
            truth = random_car(draw)
            evidences = [evidence_of(*random_likelihood(truth, draw)) for _ in range(drives)]
            if spoil is not None:
                evidences[drives // 2] = evidence_of(*random_likelihood(truth + spoil, draw, 6))
            joint = JointEstimate([0] * drives, evidences)
            estimate = joint.without(0)
            rows.append([(estimate.mean[k] - truth[k]) / estimate.sigma(k) for k in range(UNKNOWNS)])
        return np.array(rows)

    def test_of_ten_drives(self):
        errors = self.deviations(10, 150)
        rms = np.sqrt((errors ** 2).mean(axis=0))
        for unknown in range(UNKNOWNS):
            self.assertGreater(rms[unknown], 0.8, unknown)
            self.assertLess(rms[unknown], 1.15, unknown)
        self.assertLess(np.abs(errors.mean(axis=0)).max(), 0.2)

    def test_with_one_outlier(self):
        errors = self.deviations(10, 100, spoil=np.array([0.1, 0.01, 0, 0.5]))
        rms = np.sqrt((errors ** 2).mean(axis=0))
        self.assertLess(rms.max(), 1.25)

    def test_of_two_drives(self):
        errors = self.deviations(2, 150)
        self.assertLess(np.sqrt((errors ** 2).mean(axis=0)).max(), 1.15)

    def test_own_evidence_is_left_out(self):
        draw = np.random.default_rng(5)
        truth = random_car(draw)
        evidences = [evidence_of(*random_likelihood(truth, draw)) for _ in range(6)]
        joint = JointEstimate([0] * 6, evidences)
        others = JointEstimate([0] * 5, evidences[1:])
        self.assertFalse(joint.outliers)
        if joint.inflation == others.inflation == 1:
            np.testing.assert_allclose(joint.without(0).mean, others.at(0).mean, rtol=1e-3, atol=1e-4)

    def test_more_drives_tell_more(self):
        draw = np.random.default_rng(6)
        truth = random_car(draw)
        few, many = ([evidence_of(*random_likelihood(truth, draw)) for _ in range(n)] for n in (3, 20))
        self.assertLess(JointEstimate([0] * 20, many).at(0).sigma(SLIP), JointEstimate([0] * 3, few).at(0).sigma(SLIP))


class Positions(unittest.TestCase):
    def dense(self, joint, positions, evidences, drives):
        """Mean and covariance of all unknowns at once, from these drives: c, then yaw, ln L and ln H per position."""
        size = 1 + 3 * (max(positions) + 1)
        information, vector = np.zeros((size, size)), np.zeros(size)
        places = [[1 + 3 * position, 0, 2 + 3 * position, 3 + 3 * position] for position in range(max(positions) + 1)]
        before = np.linalg.inv(PRIOR)
        before[YAW, YAW] = 1 / math.radians(30) ** 2
        information[0, 0], vector[0] = before[SLIP, SLIP], before[SLIP, SLIP] * PRIOR_MEAN[SLIP]
        before[SLIP, SLIP] = 0
        for place in places:
            information[np.ix_(place, place)] += before
            vector[place] += before @ PRIOR_MEAN
        for i in drives:
            place = places[positions[i]]
            of_car, its_vector = evidences[i].of_car(joint.slip)
            information[np.ix_(place, place)] += of_car / joint.inflation ** 2
            vector[place] += its_vector / joint.inflation ** 2
        covariance = np.linalg.inv(information)
        return covariance @ vector, covariance, places

    def test_share_c(self):
        positions = [0, 0, 1, 2, 2, 2, 1]
        for seed in range(20):
            draw = np.random.default_rng(seed)
            truth = random_car(draw)
            evidences = [evidence_of(*random_likelihood(truth, draw)) for _ in positions]
            joint = JointEstimate(positions, evidences)
            kept = [i for i in range(len(positions)) if i not in joint.outliers]
            estimates = [(joint.at(positions[i]), i, kept) for i in range(len(positions))]
            estimates += [(joint.without(i), i, [k for k in kept if k != i]) for i in range(len(positions))]
            for found, i, drives in estimates:
                mean, covariance, places = self.dense(joint, positions, evidences, drives)
                place = places[positions[i]]
                covariance = covariance[np.ix_(place, place)]
                sigmas = np.sqrt(np.diag(covariance))
                np.testing.assert_allclose((found.mean - mean[place]) / sigmas, 0, atol=1e-8)
                np.testing.assert_allclose((found.covariance - covariance) / np.outer(sigmas, sigmas), 0, atol=1e-8)
                self.assertEqual(found.drives, len(drives))


class Outlier(unittest.TestCase):
    def test_is_found_and_named(self):
        draw = np.random.default_rng(7)
        truth = random_car(draw)
        evidences = [evidence_of(*random_likelihood(truth, draw, 5)) for _ in range(6)]
        evidences[3] = evidence_of(*random_likelihood(truth + [0, 0.012, 0, 0.4], draw, 8))
        self.assertEqual(JointEstimate([0] * 6, evidences).outliers, {3})

    def test_none_among_drives_of_one_car(self):
        found = 0
        for seed in range(100):
            draw = np.random.default_rng(seed)
            truth = random_car(draw)
            found += len(JointEstimate([0] * 8, [evidence_of(*random_likelihood(truth, draw)) for _ in range(8)]).outliers)
        self.assertLessEqual(found, 8)


class Intrinsic(unittest.TestCase):
    def doubts(self, *sizes, calibrated=False):
        camera = [Intrinsics(size, "plumb_bob", np.array([700.0]), np.zeros(5), 7.0) for size in sizes]
        estimates = [DriveEstimates(Drive(f"d{i}", ()), intrinsics=one, calibrated=calibrated) for i, one in enumerate(camera)]
        return Vehicle("car", estimates).doubts(estimates[0].drive)

    def test_of_different_image_sizes_are_not_combined(self):
        self.assertEqual(self.doubts((1226, 370), (1226, 370)), [])
        self.assertIn("different sizes", self.doubts((1226, 370), (1242, 375))[0])
        self.assertEqual(self.doubts((1226, 370), (1242, 375), calibrated=True), [])


class CarFile(unittest.TestCase):
    def test_keeps_the_lag_of_stabilised_images(self):
        with tempfile.TemporaryDirectory() as folder:
            own = pathlib.Path(folder) / "car.yaml"
            own.write_text("image_lag: 0.1\nimage_lag_sigma: 0.02\n")
            draw = np.random.default_rng(1)
            truth = random_car(draw)
            drives = [DriveEstimates(Drive(str(i), (), "golf", (("--vehicle", str(own)),)),
                                     evidence_of(*random_likelihood(truth, draw)), has_arm=True) for i in range(2)]
            files, _ = Vehicle("golf", drives).joint_files(drives[0].drive)
        self.assertEqual([option for option, _, _ in files], ["--vehicle"])
        self.assertIn("image_lag: 0.1\nimage_lag_sigma: 0.02\n", files[0][2])


class Moved(unittest.TestCase):
    def drive(self, yaw, pitch=0.0, draw=None):
        noise = draw.standard_normal(2) * [0.15, 0.2] if draw else [0, 0]
        rotation = Rotation(np.radians([yaw + noise[0], pitch + noise[1], 0]), np.radians([0.15, 0.2, 1]))
        return DriveEstimates(None, None, rotation)

    def positions(self, drives):
        return camera_positions(drives, lambda a, b: True)

    def test_splits_the_drives(self):
        draw = np.random.default_rng(1)
        drives = [self.drive(0, draw=draw) for _ in range(5)] + [self.drive(3, draw=draw) for _ in range(4)]
        self.assertEqual(self.positions(drives), [0] * 5 + [1] * 4)

    def test_in_pitch_splits_too(self):
        self.assertEqual(self.positions([self.drive(0), self.drive(0), self.drive(0, 4), self.drive(0, 4)]),
                         [0, 0, 1, 1])

    def test_one_drive_that_differs_is_an_outlier_unless_it_is_the_last(self):
        self.assertEqual(self.positions([self.drive(0), self.drive(4), self.drive(0), self.drive(0)]), [0, 0, 0, 0])
        self.assertEqual(self.positions([self.drive(0), self.drive(0), self.drive(4)]), [0, 0, 1])

    def test_a_drive_without_an_estimate_stays_with_those_before_it(self):
        nothing = DriveEstimates(None)
        self.assertEqual(self.positions([self.drive(0), nothing, self.drive(4), nothing, self.drive(4)]),
                         [0, 0, 1, 1, 1])

    def test_during_a_drive_parts_it_from_the_others(self):
        moved = DriveEstimates(None, None, None, moved=True)
        self.assertEqual(self.positions([self.drive(0), moved, self.drive(0)]), [0, 1, 2])

    def test_camera_that_stays_is_rarely_split(self):
        splits = 0
        for seed in range(100):
            draw = np.random.default_rng(seed)
            splits += max(self.positions([self.drive(1, -2, draw) for _ in range(10)]))
        self.assertLessEqual(splits, 3)

    def test_not_by_how_its_numbers_are_written(self):
        def positions(*options):
            drives = [DriveEstimates(Drive(str(i), (), "golf", tuple(row.items()))) for i, row in enumerate(options)]
            return Vehicle("golf", drives).positions
        self.assertEqual(positions({"--lever-arm": "1.45", "--camera-height": "1.3,0.02"},
                                   {"--lever-arm": "1.450", "--camera-height": "1.30,.02"}), [0, 0])
        self.assertEqual(positions({"--lever-arm": "1.45"}, {"--lever-arm": "1.46"}), [0, 1])
        self.assertEqual(positions({"--lever-arm": "1.45"}, {}), [0, 1])
        self.assertEqual(positions({"--camera": "/a/1.yaml"}, {"--camera": "/a/2.yaml"}), [0, 1])

    def test_by_its_height_at_the_cars_slip(self):
        def drive(height):
            information = np.diag([0, 1 / 0.0005 ** 2, 0, 1 / 0.01 ** 2])
            return DriveEstimates(None, evidence_of(information, information @ [0, 0.005, 0, math.log(height)]))
        drives = [drive(1.3), drive(1.31), drive(1.45), drive(1.46)]
        self.assertEqual(self.positions(drives), [0, 0, 1, 1])


if __name__ == "__main__":
    unittest.main()
