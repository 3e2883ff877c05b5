"""The module against the programs, on the same flight: the same numbers; and what it refuses."""
import os
import pathlib
import re
import threading
import unittest

import numpy as np
import tagtwist
from flight import SOURCE, Flight, numbers, read_columns

POSE = ["x", "y", "z", "qx", "qy", "qz", "qw"]
TWIST = ["vx_world", "vy_world", "vz_world", "wx_body", "wy_body", "wz_body"]

flight = None


def setUpModule():
    global flight
    flight = Flight()


def tearDownModule():
    flight.remove()


class FlightTest(unittest.TestCase):
    def setUp(self):
        self.config = tagtwist.load_config()

    def assert_is(self, values, expected, decimals=1e-9):
        np.testing.assert_allclose(values, expected, rtol=decimals, atol=1e-11)

    def assert_states(self, states, folder, name="states.csv"):
        """The arrays are the numbers of states.csv and covariance.csv, which have 10 digits and 12."""
        columns = read_columns(f"{folder}/{name}")
        self.assertGreater(len(states), 25)
        self.assert_is(states.t, numbers(columns, "t")[:, 0])
        self.assert_is(np.hstack([states.position, states.quaternion]), numbers(columns, *POSE))
        self.assert_is(np.hstack([states.linear_velocity, states.angular_velocity]),
                       numbers(columns, *TWIST))
        closed = states.closed_form
        self.assert_is(np.hstack([closed.position, closed.quaternion, closed.linear_velocity,
                                  closed.angular_velocity]),
                       numbers(columns, *["cf_" + column for column in POSE + TWIST]))
        self.assertEqual(list(states.status), columns["status"])
        self.assertEqual([str(n) for n in states.n_tags], columns["n_tags"])
        self.assertEqual([str(n) for n in states.n_tracks], columns["n_tracks"])
        covariances = read_columns(f"{folder}/{name.replace('states', 'covariance')}")
        del covariances["t"]
        upper = np.array([matrix[np.triu_indices(12)] for matrix in states.covariance
                          if np.isfinite(matrix).all()])
        self.assert_is(upper, numbers(covariances, *covariances), 1e-10)


class Detect(FlightTest):
    def test_tags_of_an_image(self):
        _, image = next(tagtwist.Recording(flight.path))
        _, truth = next(tagtwist.Recording(flight.path, use_detections=True))
        self.assertEqual((image.shape, image.dtype), ((240, 376), np.uint8))
        tags = tagtwist.Detector(self.config).detect(image)
        self.assertGreaterEqual(len(tags), 8)
        known = {tag.id: tag.corners for tag in truth}
        for tag in tags:
            self.assertEqual((tag.corners.shape, tag.covariance.shape), ((4, 2), (8, 8)))
            self.assertLess(np.abs(tag.corners - known[tag.id]).max(), 0.6)  # noise of 0.1 px
            self.assertTrue((np.linalg.eigvalsh(tag.covariance) > 0).all())

    def test_colour_and_strides_do_not_matter(self):
        _, image = next(tagtwist.Recording(flight.path))
        detector = tagtwist.Detector(self.config)
        expected = [(tag.id, tag.corners.tolist()) for tag in detector.detect(image)]
        wide = np.repeat(image, 2, axis=1)
        for same in np.dstack([image] * 3), wide[:, ::2], np.asfortranarray(image):
            self.assertEqual([(tag.id, tag.corners.tolist()) for tag in detector.detect(same)],
                             expected)

    def test_threads_may_share_a_detector(self):
        _, image = next(tagtwist.Recording(flight.path))
        detector = tagtwist.Detector(self.config)
        counts = []
        threads = [threading.Thread(target=lambda: counts.append(len(detector.detect(image))))
                   for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(counts, [len(detector.detect(image))] * 4)


class Live(FlightTest):
    def test_a_recording_at_its_own_speed(self):
        live = tagtwist.live(flight.path, self.config)
        states = list(live)
        self.assertEqual(len(states) + live.frames_dropped, len(list(tagtwist.Recording(flight.path))))
        self.assertEqual(live.image.shape, (240, 376))
        self.assertGreater(live.latency_ms, 0)
        self.assertTrue(all(a.t_ns < b.t_ns for a, b in zip(states, states[1:])))
        known = [state for state in states if state.status == "ok"]
        self.assertGreater(len(known), len(states) // 2)
        for state in states:
            self.assertEqual(np.isfinite(state.position).all(), state.status != "no_fix")

    def test_bodies_and_cameras_are_named(self):
        grid = "rows: 12, columns: %d, first_id: %d, tag_size_m: 0.152, row_gaps_m: 0.152, column_gaps_m: %s"
        path = os.path.join(flight.folder, "bodies.yaml")
        with open(path, "w", encoding="utf-8") as file:  # the mat's last four columns are a body of their own
            file.write("tag_map:\n  grid: {" + grid % (5, 0, [0.152, 0.152, 0.178, 0.152]) + "}\n  bodies:\n    - name: rest\n"
                       "      grid: {" + grid % (4, 60, [0.178, 0.152, 0.152]) + "}\n")
        live = tagtwist.live(flight.path, tagtwist.load_config(path))
        states = list(live)
        self.assertEqual([state.body for state in states], ["body", "rest"] * (len(states) // 2))
        self.assertEqual([state.t_ns for state in states[::2]], [state.t_ns for state in states[1::2]])
        # Frames in which the camera sees the mat, too: which are dropped is the machine's, and with them how far it predicts.
        seen = [state for state in states if state.body == "rest" and state.n_tags > 3 and state.status == "ok"]
        self.assertGreater(len(seen), 3)
        for state in seen:  # it stands where the mat has it
            error = np.abs(state.position - [0, 5 * 0.152 + 5 * 0.152 + 0.026, 0])
            self.assertTrue((error < 5 * np.sqrt(np.diag(state.covariance)[3:6]) + 0.01).all(), error)
        self.assertEqual(list(live.images), ["cam0"])
        self.assertEqual(live.images["cam0"].shape, live.image.shape)

    def test_a_callback_ends_it(self):
        stamps = []
        self.assertIsNone(tagtwist.live(flight.path, self.config, lambda s: stamps.append(s.t_ns) or len(stamps) < 5))
        self.assertEqual(len(stamps), 5)

    def test_errors_come_through(self):
        with self.assertRaisesRegex(tagtwist.Error, "nothing-here"):
            tagtwist.live("nothing-here", self.config)
        with self.assertRaisesRegex(ZeroDivisionError, "division"):
            tagtwist.live(flight.path, self.config, callback=lambda state: 1 / 0)
        with tagtwist.live(flight.path, self.config) as live:
            next(live)
        with self.assertRaises(StopIteration):
            next(live)


class EstimateLikeTheProgram(FlightTest):
    def test_batch(self):
        folder = flight.estimate("batch")
        result = tagtwist.estimate(self.config, flight.path, threads=1)
        self.assert_states(result, folder)
        self.assertIsNone(result.lagged)
        self.assertEqual(result.mode, "batch")
        again = tagtwist.estimate(self.config, tagtwist.Recording(flight.path))
        np.testing.assert_array_equal(again.covariance, result.covariance)
        np.testing.assert_array_equal(again.position, result.position)

    def test_batch_of_detections(self):
        folder = flight.estimate("detections", "--use_detections", "--notracks")
        frames = tagtwist.Recording(flight.path, use_detections=True)
        self.assert_states(tagtwist.estimate(self.config, frames), folder)
        result = tagtwist.estimate(self.config, pathlib.Path(flight.path), use_detections=True,
                                   tracks=False)
        self.assert_states(result, folder)

    def test_the_imu_of_a_recording(self):
        folder = flight.estimate("imu", "--use_detections", "--notracks", "--imu")
        result = tagtwist.estimate(self.config, flight.path, use_detections=True, tracks=False, imu=True)
        self.assert_states(result, folder)
        frames = tagtwist.Recording(flight.path, use_detections=True)
        with self.assertRaisesRegex(tagtwist.Error, "has no IMU"):
            tagtwist.estimate(self.config, ((t, tags) for t, tags in frames), imu=True)

    def test_covariances_of_corners_count(self):
        frames = list(tagtwist.Recording(flight.path, use_detections=True))
        unequal = [(t_ns, [tagtwist.Detection(tag.id, tag.corners,
                                              (0.2 if tag.id % 2 else 0.002) * np.eye(8))
                           for tag in tags]) for t_ns, tags in frames]
        sigma_z = [np.sqrt(tagtwist.estimate(self.config, given).covariance[:, 5, 5])
                   for given in (frames, unequal)]
        self.assertGreater(np.median(sigma_z[1] / sigma_z[0]), 1.05)

    def test_window_from_a_path(self):
        folder = flight.estimate("window", "--sliding_window")
        result = tagtwist.estimate(self.config, flight.path, sliding_window=True)
        self.assert_states(result, folder)
        self.assert_states(result.lagged, folder, "states_lagged.csv")

    def assert_step_by_step(self, frames, folder):
        window = tagtwist.SlidingWindow(self.config)
        states, taken = [], []
        for i, (t_ns, frame) in enumerate(frames):
            states.append(window.add(t_ns, frame))
            if i == 25:
                taken.append(window.take_lagged())
        taken.append(window.finish())
        self.assertEqual(len(window.finish()), 0)
        columns = read_columns(f"{folder}/states.csv")
        expected = numbers(columns, *POSE, *TWIST)
        for state, row, status in zip(states, expected, columns["status"]):
            self.assertEqual("no_fix" if state is None else state.status, status)
            if state is not None:
                self.assert_is(np.hstack([state.position, state.quaternion, state.linear_velocity,
                                          state.angular_velocity]), row)
        lagged = numbers(read_columns(f"{folder}/states_lagged.csv"), *POSE)
        self.assertGreater(len(taken[0]), 5)
        self.assert_is(np.vstack([np.hstack([part.position, part.quaternion]) for part in taken]),
                       lagged)

    def test_window_step_by_step(self):
        folder = flight.estimate("window", "--sliding_window")
        self.assert_step_by_step(tagtwist.Recording(flight.path), folder)

    def test_window_step_by_step_of_detections(self):
        folder = flight.estimate("window", "--sliding_window", "--use_detections", "--notracks")
        self.config.set("estimator.use_tracks", False)
        self.assert_step_by_step(tagtwist.Recording(flight.path, use_detections=True), folder)

    def test_window_step_by_step_without_refined_corners(self):
        self.config.set("detector.refine_pattern", False)
        path = f"{flight.folder}/plain.yaml"
        pathlib.Path(path).write_text("detector: {refine_pattern: false}\n", encoding="utf-8")
        folder = flight.estimate("window", "--sliding_window", "--config", path)
        self.assert_step_by_step(tagtwist.Recording(flight.path), folder)

    def test_window_step_by_step_of_a_rolling_shutter(self):
        path = f"{flight.folder}/rolling.yaml"
        with open(f"{SOURCE}/configs/course.yaml", encoding="utf-8") as course:
            text = course.read()
        changed = re.sub(r"(?m)^(\s*)line_time_s: 0\b.*$", r"\1line_time_s: 2e-5", text)
        self.assertNotEqual(changed, text)
        pathlib.Path(path).write_text(changed, encoding="utf-8")
        folder = flight.estimate("window", "--sliding_window", "--config", path)
        self.config = tagtwist.load_config(path)
        self.assert_step_by_step(tagtwist.Recording(flight.path), folder)


class CompareLikeTheProgram(FlightTest):
    def test_path(self):
        folder = flight.estimate("batch")
        for align in "none", "se3", "handeye":
            expected = flight.compare(folder, "--align", align)
            figures = tagtwist.compare(folder, align=align)
            self.assertEqual(list(figures), list(expected))
            for name, row in expected.items():
                for key, value in row["accuracy"].items():
                    self.assertEqual(figures[name][key], value)
                self.assertEqual(figures[name]["alignment"], row["alignment"])
                self.assertEqual(figures[name]["frames"], row["frames"])

    def test_result(self):
        folder = flight.estimate("batch")
        result = tagtwist.estimate(self.config, flight.path)
        own = tagtwist.compare(result)
        for name in "closed form", "optimised":
            read = tagtwist.compare(folder)[f"{folder}: {name}"]
            for key in "position_rmse_m", "rotation_rmse_rad", "velocity_rmse_mps", "rate_rmse_radps":
                self.assertAlmostEqual(own[name][key] / read[key], 1, delta=1e-4)
        self.assertAlmostEqual(own["optimised"]["nees"]["mean"] /
                               tagtwist.compare(folder)[f"{folder}: optimised"]["nees"]["mean"], 1,
                               delta=1e-3)
        truth = tagtwist.read_truth(f"{flight.path}/ground_truth.csv")
        self.assertEqual(tagtwist.compare(result, truth), own)

    def test_truth_is_needed(self):
        result = tagtwist.estimate(self.config, tagtwist.Recording(flight.path), max_frames=5)
        with self.assertRaisesRegex(tagtwist.Error, "^truth: needed, for none came"):
            tagtwist.compare(result)


class Configuration(FlightTest):
    def test_what_a_file_says(self):
        config = tagtwist.load_config(f"{SOURCE}/configs/course.yaml")
        self.assertEqual((config.camera.width, config.camera.height), (376, 240))
        self.assertEqual(config.camera.matrix[0, 0], 311.0520)
        self.assertEqual(len(config.map), 108)
        self.assertEqual(config.map.corners.shape, (108, 4, 3))
        np.testing.assert_allclose(config.map.corners[0, 3], 0, atol=1e-15)
        self.assertEqual(config.options, self.config.options)
        self.assertEqual(config.cam_from_body.shape, (4, 4))

    def test_options_are_set(self):
        self.config.set("estimator.window_frames", 7)
        self.config.set("estimator.corner_sigma_px", 0.25)
        self.config.set("detector.refine_pattern", False)
        options = self.config.options
        self.assertEqual(options["estimator"]["window_frames"], 7)
        self.assertEqual(options["estimator"]["corner_sigma_px"], 0.25)
        self.assertIs(options["detector"]["refine_pattern"], False)
        self.config.set("estimator.corner_sigma_px", None)
        self.assertIsNone(self.config.options["estimator"]["corner_sigma_px"])


class Refusals(FlightTest):
    def refuse(self, text, function, *arguments, **keywords):
        with self.assertRaises(tagtwist.Error) as caught:
            function(*arguments, **keywords)
        self.assertEqual(str(caught.exception), text)
        self.assertIsInstance(caught.exception, ValueError)

    def test_images(self):
        detect = tagtwist.Detector(self.config).detect
        expected = "image: expected a uint8 array of shape (H, W) or (H, W, 3), got "
        self.refuse(expected + "an array of float64, shape (240, 376)", detect,
                    np.zeros((240, 376)))
        self.refuse(expected + "an array of uint8, shape (240, 376, 4)", detect,
                    np.zeros((240, 376, 4), np.uint8))
        self.refuse(expected + "str", detect, "image.png")
        self.refuse(expected + "NoneType", detect, None)
        self.refuse("the image has 640 x 480 px, the configured camera 376 x 240", detect,
                    np.zeros((480, 640), np.uint8))

    def test_frames(self):
        def estimate(frames, **keywords):
            return tagtwist.estimate(self.config, frames, **keywords)
        image = np.zeros((240, 376), np.uint8)
        self.refuse("frames: expected a path or an iterable of (t_ns, image), got int", estimate, 3)
        self.refuse("frame 0: expected (t_ns, image) or (t_ns, detections), got an array of uint8, "
                    "shape (240, 376)", estimate, [image])
        self.refuse("frame 0: stamp: expected an integer, nanoseconds, got float", estimate,
                    [(0.5, image)])
        self.refuse("frame 1: stamps must grow: 5 ns follows 5 ns", estimate,
                    [(5, image), (5, image)])
        self.refuse("frame 1: expected an image as in the frames before, got list", estimate,
                    [(5, image), (6, [])])
        self.refuse("frame 1: the image has 376 x 239 px, the configured camera 376 x 240", estimate,
                    [(5, image), (6, image[1:])])
        self.refuse("frames: no frame shows a tag of the map", estimate, [(5, image), (6, image)])
        self.refuse("frames: has no frame", estimate, [])
        self.refuse('detection: "guided" needs sliding_window', estimate, [], detection="guided")
        self.refuse("no/where: no such file or folder", estimate, "no/where")

    def test_errors_of_the_iterable_come_through(self):
        def broken():
            for frame, _ in zip(tagtwist.Recording(flight.path), range(3)):
                yield frame
            raise KeyError("camera unplugged")
        with self.assertRaisesRegex(KeyError, "camera unplugged"):
            tagtwist.estimate(self.config, broken())

    def test_window(self):
        window = tagtwist.SlidingWindow(self.config)
        image = np.zeros((240, 376), np.uint8)
        self.assertIsNone(window.add(10, image))
        self.assertIsNone(window.add(np.int64(11), None))
        self.refuse("stamps must grow: 10 ns follows 11 ns", window.add, 10, image)
        self.refuse("stamp: expected an integer, nanoseconds, got float", window.add, 12.0, image)
        self.refuse("detections: expected tagtwist.Detection, got int", window.add, 12, [3])
        self.refuse("the image has 376 x 239 px, the configured camera 376 x 240", window.add, 12,
                    image[1:])
        self.assertIsNone(window.add(12, []))
        self.assertEqual(list(window.finish().status), ["no_fix"] * 3)
        self.refuse("the window is finished: no frame may follow", window.add, 13, image)

    def test_detections(self):
        corners = np.zeros((4, 2))
        self.refuse("corners: expected shape (4, 2), got (2, 4)", tagtwist.Detection, 3, corners.T)
        self.refuse("corners: expected finite pixels", tagtwist.Detection, 3, corners + np.nan)
        self.refuse("id: expected >= 0, got -1", tagtwist.Detection, -1, corners)
        self.refuse("covariance: expected shape (8, 8), got (4, 4)", tagtwist.Detection, 3, corners,
                    np.eye(4))
        self.refuse("covariance: expected a symmetric positive definite matrix [px^2]",
                    tagtwist.Detection, 3, corners, -np.eye(8))

    def test_trajectories(self):
        make = tagtwist.Trajectory
        position, quaternion = np.zeros((2, 3)), np.array([[0, 0, 0, 1.0]] * 2)
        self.refuse("position: expected shape (2, 3), got (2, 4)", make, [0, 1], quaternion,
                    quaternion)
        self.refuse("t_ns: expected stamps that grow, but [1] does not", make, [1, 1], position,
                    quaternion)
        self.refuse("t_ns: expected integers, nanoseconds, shape (N,), got an array of float64, "
                    "shape (2,)", make, np.array([0.0, 1.0]), position, quaternion)
        self.refuse("position: expected numbers, shape (2, 3), got str", make, [0, 1], "x",
                    quaternion)
        bad = make([0, 1], position, 2 * quaternion)
        self.refuse("quaternion: expected unit norm, got 2.000000 in row 0", tagtwist.compare, bad,
                    make([0, 1], position, quaternion))

    def test_configurations(self):
        self.refuse("no.yaml: cannot open: No such file or directory", tagtwist.load_config,
                    "no.yaml")
        self.refuse("estimator.window_frames: expected >= 2, got 1", self.config.set,
                    "estimator.window_frames", 1)
        self.refuse("window_frames: expected a value like 15, got 'many'", self.config.set,
                    "estimator.window_frames", "many")
        self.refuse("window.frames: no such option; Config.options has them all", self.config.set,
                    "window.frames", 1)
        self.refuse("cam_from_body: expected a rigid transform, [R t; 0 0 0 1]", setattr,
                    self.config, "cam_from_body", 2 * np.eye(4))
        self.assertEqual(self.config.options, tagtwist.load_config().options)
        self.refuse("align: expected none, se3 or handeye, got 'sim3'", tagtwist.compare, "x",
                    align="sim3")

    def test_limits(self):
        course, truth = f"{SOURCE}/configs/course.yaml", f"{flight.path}/ground_truth.csv"
        with self.assertRaisesRegex(tagtwist.Error, "nodes"):
            tagtwist.load_config(course, limits={"nodes": 10})
        with self.assertRaisesRegex(tagtwist.Error, "key_bytes"):
            tagtwist.read_camera(course, limits={"key_bytes": 10})
        with self.assertRaisesRegex(tagtwist.Error, "depth"):
            tagtwist.read_map(course, limits={"depth": 1})
        for read in tagtwist.read_truth, tagtwist.compare:
            with self.assertRaisesRegex(tagtwist.Error, "file_bytes"):
                read(truth, limits={"file_bytes": 100})
        self.assertIsNone(next(tagtwist.Recording(flight.path, limits={"frame_pixels": 100}))[1])
        with self.assertRaisesRegex(tagtwist.Error, "frame_pixels"):
            tagtwist.estimate(tagtwist.load_config(limits={"frame_pixels": 100}), flight.path)
        self.assertGreater(len(tagtwist.read_map(course, limits={"nodes": 1e6})), 0)
        self.refuse("limits: no limit node: did you mean nodes?", tagtwist.load_config,
                    limits={"node": 1})
        self.refuse("limits: nodes: expected a whole number, got 1.5", tagtwist.read_map, course,
                    limits={"nodes": 1.5})


class Help(unittest.TestCase):
    def test_everything_is_explained(self):
        self.assertIn("load_config", tagtwist.__doc__)
        for name in dir(tagtwist):
            if name.startswith("_"):
                continue
            thing = getattr(tagtwist, name)
            self.assertTrue(thing.__doc__, name)
            for member in vars(thing) if isinstance(thing, type) else ():
                if not member.startswith("_") and name != "Error":
                    self.assertTrue(getattr(thing, member).__doc__, f"{name}.{member}")


if __name__ == "__main__":
    unittest.main()
