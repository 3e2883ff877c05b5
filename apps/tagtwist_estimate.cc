#include <gflags/gflags.h>
#include <glog/logging.h>

#include <iostream>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "apps/run_estimate.h"
#include "apps/usage.h"
#include "frontend/ground_truth_io.h"

DEFINE_string(dataset, "", "Recording: a course .mat, an EuRoC/ASL folder, or a plain folder.");
DEFINE_string(config, "", "Camera, mount, tag map and options (YAML); the course's when not given.");
DEFINE_string(output, "results", "Folder to write to; made when it is missing.");
DEFINE_bool(sliding_window, false, "Online mode: a fixed-lag window instead of one batch.");
DEFINE_bool(use_detections, false, "Tag corners come from the data set, not from its images.");
DEFINE_bool(tracks, true, "Follow points through the images, where there are any.");
DEFINE_string(ground_truth, "", "Poses to compare with: CSV, TUM, EuRoC or course .mat.");
DEFINE_bool(write_covariance, false, "Also write covariance.csv: 12 x 12 for every frame.");
DEFINE_int32(threads, 0, "Threads for the images; 0: one a core. Results do not depend on it.");
DEFINE_int32(window_frames, 0, "Frames in the window; 0: as configured.");
DEFINE_double(corner_sigma_px, 0, "Noise of a corner coordinate [px]; 0: as configured, or learned.");
DEFINE_double(track_sigma_px, 0, "Noise of a track coordinate [px]; 0: likewise.");
DEFINE_double(accel_psd, 0, "Density of acceleration noise [(m/s^2)^2/Hz]; 0: likewise.");
DEFINE_double(angular_accel_psd, 0, "Density of angular acceleration noise [(rad/s^2)^2/Hz]; 0: likewise.");

using namespace tagtwist;
int main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  const Usage usage{"tagtwist_estimate", "--dataset PATH [options]", "x", {}, 0};
  ParseFlagsOrExit2(argc, argv, usage);
  auto config = FLAGS_config.empty() ? Result<Config>(DefaultConfig()) : LoadConfig(FLAGS_config);
  if (!config) return Fail(usage, config.error().message);
  cv::setNumThreads(1);
  if (FLAGS_accel_psd > 0) config->estimator.accel_psd = FLAGS_accel_psd;
  if (FLAGS_angular_accel_psd > 0) config->estimator.angular_accel_psd = FLAGS_angular_accel_psd;
  auto source = OpenDataSource(FLAGS_dataset, {FLAGS_use_detections, FLAGS_tracks});
  if (!source) return Fail(usage, source.error().message);
  RunOptions options;
  options.sliding_window = FLAGS_sliding_window;
  options.use_detections = FLAGS_use_detections;
  options.threads = FLAGS_threads > 0 ? FLAGS_threads : static_cast<int>(std::thread::hardware_concurrency());
  auto e = RunEstimate(FLAGS_dataset, source->get(), *config, options);
  if (!e) return Fail(usage, e.error().message);
  for (auto& w : e->warnings) std::cerr << "warning: " << w << "\n";
  std::vector<double> rp = e->reprojection_px; std::sort(rp.begin(), rp.end());
  std::cout << "noise " << e->noise.corner_sigma_px << " " << e->noise.track_sigma_px << " " << e->noise.accel_psd << " " << e->noise.angular_accel_psd << " repr " << rp[rp.size()/2] << "\n";
  auto med = [](std::vector<double> v) { std::sort(v.begin(), v.end()); return v[v.size()/2]; };
  std::cout << "ms detect " << med(e->times.detect_ms) << " track " << med(e->times.track_ms) << " seed " << med(e->times.seed_ms) << " opt " << med(e->times.optimise_ms) << "\n";
  const auto& gt = (*source)->ground_truth();
  auto evalu = [&](const std::vector<FrameEstimate>& fr, const char* name) {
    double p = 0, v = 0, w = 0, r=0, cp = 0, cv = 0, cw = 0, nees = 0; int n = 0, nc = 0; std::vector<double> d, cd;
    for (auto& f : fr) for (auto& g : gt) if (std::abs(g.t_ns - f.t_ns) < 2000 && f.status != FrameStatus::kNoFix) {
      double e2 = (f.state.world_from_body.translation() - g.world_from_body.translation()).squaredNorm();
      BodyState t; t.world_from_body = g.world_from_body; if (g.twist) t.twist = *g.twist;
      StateVector e12 = Difference(f.state, t); nees += e12.dot(f.covariance.llt().solve(e12));
      p += e2; r += e12.head<3>().squaredNorm(); v += e12.segment<3>(6).squaredNorm(); w += e12.tail<3>().squaredNorm(); ++n; d.push_back(std::sqrt(e2));
      if (f.closed_form.world_from_body) { double c2 = (f.closed_form.world_from_body->translation() - g.world_from_body.translation()).squaredNorm(); cp += c2; cd.push_back(std::sqrt(c2)); ++nc;
        if (f.closed_form.twist_low_pass) { cv += (f.closed_form.twist_low_pass->v_world - t.twist.v_world).squaredNorm(); cw += (f.closed_form.twist_low_pass->omega_body - t.twist.omega_body).squaredNorm(); } }
    }
    if (!n) return;
 std::cout << name << " n " << n << " pos rmse " << std::sqrt(p/n) << " med " << med(d) << " rot " << std::sqrt(r/n) << " vel " << std::sqrt(v/n) << " rate " << std::sqrt(w/n) << " nees/12 " << nees/n/12 << " | cf pos " << std::sqrt(cp/nc) << " med " << med(cd) << " vel " << std::sqrt(cv/nc) << " rate " << std::sqrt(cw/nc) << "\n";
  };
  evalu(e->frames, "frames"); if (!e->lagged.empty()) evalu(e->lagged, "lagged");
  std::cout << e->frames.size() << " frames, lagged " << e->lagged.size() << "\n";
}
