"""ATE and RPE against the definitions of the tool evo, written anew with NumPy.

Those of evo: APE is |p_est - p_ref| and the angle of R_ref^T R_est after Umeyama's alignment without
scale; RPE, of all pairs, is of (Q_i^-1 Q_j)^-1 (P_i^-1 P_j), with j = i + delta in frames, or the j > i
to which the estimate's path is nearest to delta in metres, and within a tenth of it.
"""
import unittest

import numpy as np
import tagtwist

RATE_HZ = 50


def quaternion_to_matrix(xyzw):
    x, y, z, w = xyzw / np.linalg.norm(xyzw)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def matrices(trajectory):
    """(N, 4, 4) of the poses."""
    out = np.tile(np.eye(4), (len(trajectory), 1, 1))
    out[:, :3, 3] = trajectory.position
    out[:, :3, :3] = [quaternion_to_matrix(q) for q in trajectory.quaternion]
    return out


def umeyama(x, y):
    """4 x 4 that takes the points x (N, 3) onto y: Umeyama 1991 by SVD, without scale."""
    mean_x, mean_y = x.mean(axis=0), y.mean(axis=0)
    u, _, vt = np.linalg.svd((y - mean_y).T @ (x - mean_x) / len(x))
    out = np.eye(4)
    out[:3, :3] = u @ np.diag([1, 1, np.sign(np.linalg.det(u) * np.linalg.det(vt))]) @ vt
    out[:3, 3] = mean_y - out[:3, :3] @ mean_x
    return out


def angle(rotation):
    """Of a rotation matrix [rad], well conditioned for small ones, too."""
    skew = rotation - rotation.T
    sine = np.linalg.norm([skew[2, 1], skew[0, 2], skew[1, 0]]) / 2
    return np.arctan2(sine, (np.trace(rotation) - 1) / 2)


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


def ape(reference, estimate):
    """Translations [m] and angles [rad] of the absolute errors."""
    return (np.linalg.norm(estimate[:, :3, 3] - reference[:, :3, 3], axis=1),
            [angle(r[:3, :3].T @ e[:3, :3]) for r, e in zip(reference, estimate)])


def rpe(reference, estimate, pairs):
    """RMS translation [m] and angle [rad] of the relative errors, and their number."""
    errors = [np.linalg.inv(np.linalg.inv(reference[i]) @ reference[j]) @
              (np.linalg.inv(estimate[i]) @ estimate[j]) for i, j in pairs]
    return rms([np.linalg.norm(e[:3, 3]) for e in errors]), rms([angle(e[:3, :3]) for e in errors]), \
        len(pairs)


def flight_and_estimate(seed):
    """A smooth flight, and it moved rigidly with noise on every pose."""
    rng = np.random.default_rng(seed)
    t = np.arange(250) / RATE_HZ
    position = np.stack([np.sin(0.7 * t), 1.3 * np.cos(0.5 * t), 1.5 + 0.3 * np.sin(1.1 * t)], 1)
    vector = np.stack([0.2 * np.sin(0.9 * t), 0.15 * np.cos(0.6 * t), 0.4 * np.sin(0.35 * t)], 1)
    quaternion = np.hstack([vector, np.sqrt(1 - np.sum(vector ** 2, 1))[:, None]])
    t_ns = np.round(1e9 * t).astype(np.int64)
    truth = tagtwist.Trajectory(t_ns, position, quaternion)
    turn = quaternion_to_matrix(np.array([0.1, -0.3, 0.5, 0.8]))
    moved = position @ turn.T + [0.3, -2, 1] + 0.01 * rng.standard_normal(position.shape)
    noisy = quaternion + 0.01 * rng.standard_normal(quaternion.shape)
    noisy /= np.linalg.norm(noisy, axis=1)[:, None]
    return truth, tagtwist.Trajectory(t_ns, moved, noisy)


class LikeEvo(unittest.TestCase):
    def assert_figures(self, figures, reference, estimate):
        translations, angles = ape(reference, estimate)
        self.assertAlmostEqual(figures["position_rmse_m"], rms(translations), delta=1e-6)
        self.assertAlmostEqual(figures["position_median_m"], np.median(translations), delta=1e-6)
        self.assertAlmostEqual(figures["rotation_rmse_rad"], rms(angles), delta=1e-6)
        self.assertAlmostEqual(figures["rotation_median_rad"], np.median(angles), delta=1e-6)

    def assert_rpe(self, figures, expected):
        self.assertAlmostEqual(figures["translation_rmse_m"], expected[0], delta=1e-6)
        self.assertAlmostEqual(figures["rotation_rmse_rad"], expected[1], delta=1e-6)
        self.assertEqual(figures["pairs"], expected[2])

    def test_without_alignment(self):
        truth, estimate = flight_and_estimate(1)
        figures = tagtwist.compare(estimate, truth)["trajectory"]
        self.assert_figures(figures, matrices(truth), matrices(estimate))
        self.assertGreater(figures["position_rmse_m"], 1)

    def test_aligned(self):
        truth, estimate = flight_and_estimate(2)
        figures = tagtwist.compare(estimate, truth, align="se3")["trajectory"]
        align = umeyama(estimate.position, truth.position)
        self.assert_figures(figures, matrices(truth), align @ matrices(estimate))
        self.assertLess(figures["position_rmse_m"], 0.03)

    def test_relative_errors_by_frames(self):
        truth, estimate = flight_and_estimate(3)
        reference, estimated = matrices(truth), matrices(estimate)
        for delta in 1, 7:
            pairs = [(i, i + delta) for i in range(len(truth) - delta)]
            figures = tagtwist.compare(estimate, truth, rpe_frames=delta)["trajectory"]
            self.assert_rpe(figures["rpe_frames"], rpe(reference, estimated, pairs))

    def test_relative_errors_by_time(self):
        truth, estimate = flight_and_estimate(4)
        delta = round(0.4 * RATE_HZ)
        pairs = [(i, i + delta) for i in range(len(truth) - delta)]
        figures = tagtwist.compare(estimate, truth, rpe_seconds=0.4)["trajectory"]
        self.assert_rpe(figures["rpe_time"], rpe(matrices(truth), matrices(estimate), pairs))

    def test_relative_errors_by_distance(self):
        truth, estimate = flight_and_estimate(5)
        gone = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(estimate.position, axis=0),
                                                              axis=1))])
        for delta in 0.05, 1.0:  # the shorter one is often missed: steps have noise
            pairs = []
            for i in range(len(gone) - 1):
                off = np.abs(gone[i + 1:] - gone[i] - delta)
                if off.min() <= 0.1 * delta:
                    pairs.append((i, i + 1 + int(np.argmin(off))))
            self.assertLess(len(pairs), len(gone) - 20)
            figures = tagtwist.compare(estimate, truth, rpe_metres=delta)["trajectory"]
            self.assert_rpe(figures["rpe_distance"],
                            rpe(matrices(truth), matrices(estimate), pairs))


if __name__ == "__main__":
    unittest.main()
