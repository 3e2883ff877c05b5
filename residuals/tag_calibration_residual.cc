#include "residuals/tag_calibration_residual.h"

#include "frontend/base/take_shape.h"
#include "frontend/types/so3.h"
#include "residuals/lens.h"

namespace tagtwist::internal {
namespace {

// The upper triangle of the whitener times the columns, in place.
template <typename Matrix>
void Whiten(const Eigen::Matrix<double, 8, 8>& whitener, Matrix* columns) {
  for (Eigen::Index j = 0; j < columns->cols(); ++j) {
    auto column = columns->col(j);
    for (int i = 0; i < 8; ++i) {
      double sum = 0;
      for (int k = i; k < 8; ++k) sum += whitener(i, k) * column(k);
      column(i) = sum;
    }
  }
}

}  // namespace

bool EvaluateTagCalibration(const Tag& tag, double scale, const Camera& camera,
                            const Pose& world_from_cam,
                            const std::array<Eigen::Vector2d, 4>& pixels,
                            const Eigen::Matrix<double, 8, 8>& whitener,
                            const RollingShutter& shutter, TagCalibrationResidual* out,
                            bool shared) {
  const Eigen::Matrix3d at_stamp = world_from_cam.rotation().toRotationMatrix().transpose();
  const Eigen::Matrix3d tag_rotation = tag.world_from_tag.rotation().toRotationMatrix();
  const std::array<Eigen::Vector3d, 4> corners = TagCornersInWorld(tag);
  TakeShape(8, LensSize(camera), &out->by_lens);
  for (int i = 0; i < 4; ++i) {
    const auto c = static_cast<size_t>(i);
    const Eigen::Vector3d in_world = scale * corners[c];
    const double row = pixels[c].y(), t_s = shutter.line_time_s * row;
    const Eigen::Matrix3d turn = t_s == 0
                                     ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                     : ExpSo3(-t_s * shutter.motion.omega_body).toRotationMatrix();
    const Eigen::Matrix3d cam_from_world = turn * at_stamp;
    const Eigen::Vector3d in_cam =
        cam_from_world * (in_world - world_from_cam.translation() - t_s * shutter.motion.v_world);
    Eigen::Vector2d predicted;
    Eigen::Matrix<double, 2, 3> by_point;
    if (!camera.Project(in_cam, &predicted, &by_point)) return false;
    const Eigen::Matrix<double, 2, 3> by_world = by_point * cam_from_world;
    out->residual.segment<2>(2 * i) = predicted - pixels[c];
    const Eigen::Matrix<double, 2, 3> by_turn = by_point * Hat(in_cam);
    out->by_cam.middleRows<2>(2 * i) << by_turn * turn, -by_world;
    if (!shared) continue;
    const Eigen::Vector3d in_tag =
        tag_rotation.transpose() * (corners[c] - tag.world_from_tag.translation());
    out->by_tag.middleRows<2>(2 * i) << -scale * by_world * tag_rotation * Hat(in_tag),
        scale * by_world, (i % 2 == 0 ? scale : -scale) * by_world * tag_rotation.col(2);
    out->by_log_scale.segment<2>(2 * i) = by_world * in_world;
    out->by_line_time.segment<2>(2 * i) =
        row * (by_turn * shutter.motion.omega_body - by_world * shutter.motion.v_world);
    out->by_lens.middleRows<2>(2 * i) = PixelByLens(camera, in_cam, predicted);
  }
  Whiten(whitener, &out->residual);
  Whiten(whitener, &out->by_cam);
  if (!shared) return true;
  Whiten(whitener, &out->by_tag);
  Whiten(whitener, &out->by_log_scale);
  Whiten(whitener, &out->by_line_time);
  Whiten(whitener, &out->by_lens);
  return true;
}

}  // namespace tagtwist::internal
