#include "estimator/calibration/set_up/set_up_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

constexpr Eigen::Index kPoseSize = 6;
using Changes = Eigen::Matrix<double, kSetUpChanges, 1>;
using Jacobian = Eigen::Matrix<double, 2, kPoseSize + kSetUpChanges>;
using Normal = Eigen::Matrix<double, kPoseSize + kSetUpChanges, kPoseSize + kSetUpChanges>;
using Gradient = Eigen::Matrix<double, kPoseSize + kSetUpChanges, 1>;

Changes ToVector(const SetUpChange& c) {
  Changes out;
  out << c.log_focal, c.log_resolution, c.centre_px, c.radial, c.log_size, c.line_time_s,
      c.log_stretch, c.log_squeeze;
  return out;
}

SetUpChange FromVector(const Changes& v) {
  SetUpChange out;
  out.log_focal = v(0);
  out.log_resolution = v(1);
  out.centre_px = v.segment<2>(2);
  out.radial = v.segment<2>(4);
  out.log_size = v(6);
  out.line_time_s = v(7);
  out.log_stretch = v.segment<2>(8);
  out.log_squeeze = v(10);
  return out;
}

struct Model {
  const Camera& given;
  Camera camera;  // changed
  const TagMap& map;
  SetUpChange change;
};

struct Point {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), from_centre = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

// Where a corner is in the camera when its row is read, as a function of the pose alone.
Eigen::Vector3d Moving(const PosedFrame& frame, const Eigen::Vector3d& world) {
  if (!(frame.between_s > 0)) return Eigen::Vector3d::Zero();
  return (frame.cam_after * world - frame.cam_before * world) / frame.between_s;
}

// Error and derivatives of a corner; false where it does not project.
bool Linearise(const Model& model, const PosedFrame& frame, const Pose& cam_from_world,
               const Point& point, Eigen::Vector2d* error, Jacobian* jacobian) {
  const double size = std::exp(model.change.log_size);
  const Eigen::Vector2d stretch = model.change.log_stretch.array().exp();
  Eigen::Vector3d centre = point.centre;
  centre.head<2>().array() *= stretch.array();
  const Eigen::Vector3d world = centre + size * point.from_centre;
  const Eigen::Matrix3d rotation = cam_from_world.rotation().toRotationMatrix();
  const Eigen::Vector3d moving = point.pixel.y() * Moving(frame, world);
  const Eigen::Vector3d in_cam =
      rotation * world + cam_from_world.translation() + model.change.line_time_s * moving;
  Eigen::Vector2d predicted;
  Eigen::Matrix<double, 2, 3> by_point;
  if (!model.camera.Project(in_cam, &predicted, &by_point)) return false;
  *error = predicted - point.pixel;
  if (jacobian == nullptr) return true;
  const Eigen::Matrix<double, 2, 3> by_world = by_point * rotation;
  for (int i = 0; i < 2; ++i) {
    jacobian->row(i).head<3>() = world.cross(by_world.row(i).transpose());
  }
  jacobian->middleCols<3>(3) = by_point;
  const Camera& c = model.camera;
  const Eigen::Vector2d from_centre = predicted - Eigen::Vector2d(c.cx, c.cy);
  jacobian->col(6) = from_centre;
  const double resolution = std::exp(model.change.log_resolution);
  const double squeezed_cx = resolution * std::exp(model.change.log_squeeze) * model.given.cx;
  jacobian->col(7) = from_centre + Eigen::Vector2d(squeezed_cx, resolution * model.given.cy);
  jacobian->middleCols<2>(8).setIdentity();
  const Eigen::Vector2d n = in_cam.head<2>() / in_cam.z();
  const Eigen::Vector2d out = n.squaredNorm() * Eigen::Vector2d(c.fx * n.x(), c.fy * n.y());
  jacobian->col(10) = out;
  jacobian->col(11) = n.squaredNorm() * out;
  jacobian->col(12) = by_world * size * point.from_centre;
  jacobian->col(13) = by_point * moving;
  jacobian->col(14) = by_world.col(0) * centre.x();
  jacobian->col(15) = by_world.col(1) * centre.y();
  jacobian->col(16) << from_centre.x() + squeezed_cx, 0;
  return true;
}

std::array<Point, 4> PointsOf(const TagDetection& tag, const TagMap& map) {
  const auto& corners = map.CornersInWorld(tag.id);
  const Eigen::Vector3d centre = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  std::array<Point, 4> out;
  for (size_t i = 0; i < 4; ++i) out[i] = {centre, corners[i] - centre, tag.corners[i]};
  return out;
}

// Squares of a tag's errors; infinite where a corner does not project.
double TagSquares(const Model& model, const PosedFrame& frame, const Pose& pose,
                  const TagDetection& tag) {
  double squares = 0;
  for (const Point& point : PointsOf(tag, model.map)) {
    Eigen::Vector2d error;
    if (!Linearise(model, frame, pose, point, &error, nullptr)) return INFINITY;
    squares += error.squaredNorm();
  }
  return squares;
}

// Huber in the tag's RMS: its square and weight; a tag that does not project costs as one far off.
double RobustSquares(double squares, double huber_px, double* weight) {
  const double rms = std::min(0.5 * std::sqrt(squares), 1e4);
  *weight = rms <= huber_px ? 1 : huber_px / rms;
  return rms <= huber_px ? 4 * rms * rms : 4 * huber_px * (2 * rms - huber_px);
}

double CostOf(const Model& model, const std::vector<PosedFrame>& frames,
              const std::vector<Pose>& poses, double huber_px) {
  double cost = 0, weight = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    for (const TagDetection& tag : frames[i].seen.tags) {
      cost += RobustSquares(TagSquares(model, frames[i], poses[i], tag), huber_px, &weight);
    }
  }
  return cost;
}

void NormalOf(const Model& model, const PosedFrame& frame, const Pose& pose, double huber_px,
              Normal* normal, Gradient* gradient) {
  normal->setZero();
  gradient->setZero();
  for (const TagDetection& tag : frame.seen.tags) {
    double weight = 0;
    const double squares = TagSquares(model, frame, pose, tag);
    if (!std::isfinite(squares)) continue;
    RobustSquares(squares, huber_px, &weight);
    for (const Point& point : PointsOf(tag, model.map)) {
      Eigen::Vector2d error;
      Jacobian jacobian;
      if (!Linearise(model, frame, pose, point, &error, &jacobian)) continue;
      *normal += weight * jacobian.transpose() * jacobian;
      *gradient += weight * jacobian.transpose() * error;
    }
  }
}

// One damped step of all poses and the free changes.
struct Step {
  std::vector<Eigen::Matrix<double, kPoseSize, 1>> poses;
  Changes changes = Changes::Zero();
};

Step Solve(const std::vector<Normal>& normals, const std::vector<Gradient>& gradients,
           const FreeChanges& free, double damping) {
  std::vector<Eigen::Index> columns;
  for (size_t i = 0; i < kSetUpChanges; ++i) {
    if (free[i]) columns.push_back(kPoseSize + static_cast<Eigen::Index>(i));
  }
  const auto count = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd shared = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::LDLT<Eigen::Matrix<double, 6, 6>>> factors;
  std::vector<Eigen::MatrixXd> couplings;
  for (size_t i = 0; i < normals.size(); ++i) {
    Eigen::Matrix<double, 6, 6> of_pose = normals[i].topLeftCorner<6, 6>();
    of_pose.diagonal() *= 1 + damping;
    of_pose.diagonal().array() += 1e-9;
    factors.emplace_back(of_pose);
    Eigen::MatrixXd coupling(6, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      coupling.col(k) = normals[i].col(columns[static_cast<size_t>(k)]).head<6>();
      right(k) -= gradients[i](columns[static_cast<size_t>(k)]);
      for (Eigen::Index l = 0; l < count; ++l) {
        const double entry =
            normals[i](columns[static_cast<size_t>(k)], columns[static_cast<size_t>(l)]);
        shared(k, l) += k == l ? entry * (1 + damping) : entry;
      }
    }
    shared -= coupling.transpose() * factors.back().solve(coupling);
    right += coupling.transpose() * factors.back().solve(gradients[i].head<6>());
    couplings.push_back(std::move(coupling));
  }
  Step out;
  Eigen::VectorXd changes = Eigen::VectorXd::Zero(count);
  if (count > 0) changes = shared.ldlt().solve(right);
  for (Eigen::Index k = 0; k < count; ++k) {
    out.changes(columns[static_cast<size_t>(k)] - kPoseSize) = changes(k);
  }
  for (size_t i = 0; i < normals.size(); ++i) {
    out.poses.push_back(-factors[i].solve(gradients[i].head<6>() + couplings[i] * changes));
  }
  return out;
}

std::vector<Pose> Moved(const std::vector<Pose>& poses, const Step& step) {
  std::vector<Pose> out;
  for (size_t i = 0; i < poses.size(); ++i) {
    out.push_back(MakePose(poses[i].rotation() * ExpSo3(step.poses[i].head<3>()),
                           poses[i].translation() + step.poses[i].tail<3>()));
  }
  return out;
}

double MedianTag(const Model& model, const std::vector<PosedFrame>& frames,
                 const std::vector<Pose>& poses) {
  std::vector<double> rms;
  for (size_t i = 0; i < frames.size(); ++i) {
    for (const TagDetection& tag : frames[i].seen.tags) {
      rms.push_back(0.5 * std::sqrt(TagSquares(model, frames[i], poses[i], tag)));
    }
  }
  if (rms.empty()) return 0;
  const auto middle = rms.begin() + static_cast<std::ptrdiff_t>(rms.size() / 2);
  std::nth_element(rms.begin(), middle, rms.end());
  return *middle;
}

}  // namespace

Camera Changed(const Camera& camera, const SetUpChange& change) {
  Camera out = camera;
  const double resolution = std::exp(change.log_resolution);
  const double squeeze = std::exp(change.log_squeeze);
  out.fx *= resolution * squeeze * std::exp(change.log_focal);
  out.fy *= resolution * std::exp(change.log_focal);
  out.cx = resolution * squeeze * camera.cx + change.centre_px.x();
  out.cy = resolution * camera.cy + change.centre_px.y();
  out.k1 += change.radial.x();
  out.k2 += change.radial.y();
  return out;
}

SetUpFit FitSetUp(const std::vector<PosedFrame>& frames, const Camera& camera, const TagMap& map,
                  const FreeChanges& free, const SetUpChange& start, double huber_px) {
  constexpr int kMaxSteps = 60;
  std::vector<Pose> poses;
  SetUpFit out;
  for (const PosedFrame& frame : frames) {
    poses.push_back(frame.cam_from_world);
    out.corners += 4 * frame.seen.tags.size();
  }
  const auto model_of = [&](const SetUpChange& change) {
    return Model{camera, Changed(camera, change), map, change};
  };
  out.change = start;
  out.cost = CostOf(model_of(start), frames, poses, huber_px);
  double damping = 1e-4;
  for (int i = 0; i < kMaxSteps && damping < 1e8; ++i) {
    const Model model = model_of(out.change);
    std::vector<Normal> normals(frames.size());
    std::vector<Gradient> gradients(frames.size());
    for (size_t k = 0; k < frames.size(); ++k) {
      NormalOf(model, frames[k], poses[k], huber_px, &normals[k], &gradients[k]);
    }
    double gain = 0;
    for (; damping < 1e8; damping *= 10) {
      const Step step = Solve(normals, gradients, free, damping);
      const SetUpChange change = FromVector(ToVector(out.change) + step.changes);
      const std::vector<Pose> moved = Moved(poses, step);
      const double cost = CostOf(model_of(change), frames, moved, huber_px);
      if (!(cost < out.cost)) continue;
      gain = out.cost - cost;
      out.change = change;
      out.cost = cost;
      poses = moved;
      damping = std::max(1e-9, 0.1 * damping);
      break;
    }
    if (gain <= 1e-6 * out.cost) break;
  }
  out.median_px = MedianTag(model_of(out.change), frames, poses);
  return out;
}

}  // namespace tagtwist::internal
