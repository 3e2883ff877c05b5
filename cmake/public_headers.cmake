# The headers that are installed, below include/tagtwist/: all that may change only with a new version. Each includes
# public ones alone (test `public_headers`); all else of the libraries is their own.
set(TAGTWIST_PUBLIC_HEADERS
  # values
  frontend/base/files/input_digest.h
  frontend/base/for_ranges.h
  frontend/base/limits.h
  frontend/base/named_enum.h
  frontend/base/ratio_statistic.h
  frontend/base/result.h
  frontend/base/spans.h
  frontend/base/time_up.h
  frontend/types/body_state.h
  frontend/types/camera.h
  frontend/types/measurements.h
  frontend/types/optional_apart.h
  frontend/types/pose.h
  frontend/types/rig.h
  frontend/types/so3.h
  frontend/types/tag_map.h
  frontend/types/truth.h
  # images to measurements
  frontend/closed_form_options.h
  frontend/flow/klt_options.h
  frontend/front_end.h
  frontend/tags/filter_tags.h
  frontend/tags/tag_detector.h
  frontend/tags/tag_finder.h
  # files
  frontend/io/recordings/data_source.h
  frontend/io/recordings/rig/rig_source.h
  frontend/io/setup/tag_map_file.h
  frontend/io/trajectories/trajectory_file.h
  frontend/io/trajectories/trajectory_rows.h
  # flights without a camera
  frontend/simulation/named_flights.h
  frontend/simulation/renderer_options.h
  frontend/simulation/simulator.h
  frontend/simulation/spline_trajectory.h
  # measurements to trajectories
  residuals/motion_prior.h
  estimator/linear/block.h
  estimator/graph/estimator_options.h
  estimator/graph/graph_state.h
  estimator/graph/noise_model.h
  estimator/graph/trajectory.h
  estimator/result/camera_share.h
  estimator/result/estimate.h
  estimator/result/reprojection_errors.h
  estimator/result/run_facts.h
  estimator/result/systematic_share.h
  estimator/batch/batch.h
  estimator/window/sliding_window.h
  estimator/window/window_output.h
  # against ground truth
  estimator/evaluation/alignment_types.h
  estimator/evaluation/comparison_key.h
  estimator/evaluation/evaluation.h
  estimator/evaluation/pose_series.h
  # images in, states out
  estimator/calibration/options.h
  estimator/online/camera_image.h
  estimator/online/config.h
  estimator/online/online_estimator.h
  estimator/online/online_options.h
  estimator/imu/imu_options.h
  estimator/result/imu_result.h
  # results as files
  estimator/report/findings/comparison_table.h
  estimator/report/result_writer.h
)
