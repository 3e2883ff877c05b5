#include "frontend/types/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "frontend/types/lens/lens.h"

namespace tagtwist::internal::camera_test {
namespace {

struct NamedLens {
  std::string name;
  LensModel model = LensModel::kRadialTangential;
  std::vector<double> k;  // OpenCV's order
};
void PrintTo(const NamedLens& lens, std::ostream* out) { *out << lens.name; }

Camera MakeCamera(const NamedLens& lens) {
  Camera c;
  c.width = 752, c.height = 480, c.fx = 458.6, c.fy = 457.3, c.cx = 367.2, c.cy = 248.4;
  c.lens = lens.model;
  for (size_t i = 0; i < lens.k.size(); ++i) {
    c.*LensCoefficients(lens.model)[i].value = lens.k[i];
  }
  return c;
}

// The models over a sphere or an ellipsoid and the field-of-view model as their papers have them,
// from a point instead of its normalised coordinates.
Eigen::Vector2d DistortByThePaper(const NamedLens& lens, const Eigen::Vector3d& p) {
  const std::vector<double>& k = lens.k;
  const double radius = p.head<2>().norm();
  switch (lens.model) {
    case LensModel::kDoubleSphere: {
      const double d1 = p.norm(), z = k[0] * d1 + p.z(), d2 = std::hypot(radius, z);
      return p.head<2>() / (k[1] * d2 + (1 - k[1]) * z);
    }
    case LensModel::kExtendedUnified: {
      const double d = std::sqrt(k[1] * radius * radius + p.z() * p.z());
      return p.head<2>() / (k[0] * d + (1 - k[0]) * p.z());
    }
    case LensModel::kOmni: {
      const Eigen::Vector3d on_sphere = p.normalized();
      const Eigen::Vector2d m = on_sphere.head<2>() / (on_sphere.z() + k[0]);
      const double r2 = m.squaredNorm(), bend = 1 + k[1] * r2 + k[2] * r2 * r2;
      return {m.x() * bend + 2 * k[3] * m.x() * m.y() + k[4] * (r2 + 2 * m.x() * m.x()),
              m.y() * bend + k[3] * (r2 + 2 * m.y() * m.y()) + 2 * k[4] * m.x() * m.y()};
    }
    default:
      if (radius == 0) return Eigen::Vector2d::Zero();
      return std::atan(2 * radius / p.z() * std::tan(k[0] / 2)) / k[0] * p.head<2>() / radius;
  }
}

cv::Point2d ProjectByOpenCv(const NamedLens& lens, const Camera& c, const Eigen::Vector3d& p) {
  const std::vector<cv::Point3d> points = {{p.x(), p.y(), p.z()}};
  const cv::Matx33d k(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  std::vector<cv::Point2d> pixels;
  const cv::Vec3d none(0, 0, 0);
  if (lens.model != LensModel::kRadialTangential && lens.model != LensModel::kEquidistant) {
    const Eigen::Vector2d m = DistortByThePaper(lens, p);
    return {c.fx * m.x() + c.cx, c.fy * m.y() + c.cy};
  }
  if (lens.model == LensModel::kEquidistant) {
    cv::fisheye::projectPoints(points, pixels, none, none, k, lens.k);
  } else {
    cv::projectPoints(points, none, none, k, lens.k, pixels);
  }
  return pixels[0];
}

class Lens : public testing::TestWithParam<NamedLens> {
 protected:
  const Camera camera_ = MakeCamera(GetParam());

  /// Calls `see` with points at 1.7 m over the whole view of a 752 x 480 image.
  template <typename See>
  void ForPointsInView(const See& see) const {
    for (int i = -9; i <= 9; ++i) {
      for (int j = -6; j <= 6; ++j) see(1.7 * Eigen::Vector3d(0.09 * i, 0.09 * j, 1));
    }
  }
};

TEST_P(Lens, ProjectsLikeOpenCvOrThePaper) {
  ForPointsInView([&](const Eigen::Vector3d& point) {
    Eigen::Vector2d pixel;
    ASSERT_TRUE(camera_.Project(point, &pixel));
    const cv::Point2d expected = ProjectByOpenCv(GetParam(), camera_, point);
    EXPECT_LT((pixel - Eigen::Vector2d(expected.x, expected.y)).norm(), 1e-9);
  });
}

TEST_P(Lens, UnprojectInvertsProject) {
  ForPointsInView([&](const Eigen::Vector3d& point) {
    Eigen::Vector2d pixel;
    ASSERT_TRUE(camera_.Project(point, &pixel));
    const auto ray = camera_.Unproject(pixel);
    ASSERT_TRUE(ray);
    EXPECT_LT((*ray - point.hnormalized()).norm(), 1e-11) << point.transpose();
  });
}

TEST_P(Lens, JacobiansAreTheDerivatives) {
  constexpr double kStep = 1e-5;
  double largest = 0;
  ForPointsInView([&](const Eigen::Vector3d& point) {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> d_pixel, numeric;
    ASSERT_TRUE(camera_.Project(point, &pixel, &d_pixel));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
      Eigen::Vector2d ahead, back;
      ASSERT_TRUE(camera_.Project(point + step, &ahead));
      ASSERT_TRUE(camera_.Project(point - step, &back));
      numeric.col(k) = (ahead - back) / (2 * kStep);
    }
    EXPECT_LT((d_pixel - numeric).norm(), 1e-6) << point.transpose();
    largest = std::max(largest, d_pixel.norm());

    Eigen::Matrix2d d_ray, numeric_ray;
    ASSERT_TRUE(camera_.Unproject(pixel, &d_ray));
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d step = 1e-3 * Eigen::Vector2d::Unit(k);
      numeric_ray.col(k) =
          (*camera_.Unproject(pixel + step) - *camera_.Unproject(pixel - step)) / 2e-3;
    }
    EXPECT_LT((d_ray - numeric_ray).norm(), 1e-7) << point.transpose();
  });
  EXPECT_GT(largest, 100);
}

INSTANTIATE_TEST_SUITE_P(
    All, Lens,
    testing::Values(
        NamedLens{"None", LensModel::kRadialTangential, {0, 0, 0, 0}},
        NamedLens{"RadTan4", LensModel::kRadialTangential, {-0.2834, 0.0739, 1.9e-4, 1.8e-5}},
        NamedLens{"RadTan5", LensModel::kRadialTangential, {-0.3, 0.12, 1e-3, -5e-4, -0.02}},
        NamedLens{"Rational8",
                  LensModel::kRadialTangential,
                  {0.42, -0.21, 8e-4, -4e-4, 0.03, 0.71, -0.15, 0.06}},
        NamedLens{"EquidistantBare", LensModel::kEquidistant, {0, 0, 0, 0}},
        NamedLens{"Equidistant", LensModel::kEquidistant, {-0.013, 0.021, -0.012, 0.003}},
        NamedLens{"DoubleSphere", LensModel::kDoubleSphere, {-0.2, 0.59}},
        NamedLens{"DoubleSphereFlat", LensModel::kDoubleSphere, {0.3, 0.4}},
        NamedLens{"ExtendedUnified", LensModel::kExtendedUnified, {0.6, 1.1}},
        NamedLens{"ExtendedUnifiedFlat", LensModel::kExtendedUnified, {0.3, 0.8}},
        NamedLens{"OmniBare", LensModel::kOmni, {0.8, 0, 0, 0, 0}},
        NamedLens{"Omni", LensModel::kOmni, {0.99, -0.2, 0.07, 1e-3, -5e-4}},
        NamedLens{"OmniBeyondOne", LensModel::kOmni, {1.8, -0.1, 0.02, 1e-4, 2e-4}},
        NamedLens{"FieldOfView", LensModel::kFieldOfView, {0.9}}),
    [](const auto& test) { return test.param.name; });

TEST_P(Lens, CoefficientsHaveTheirDerivatives) {
  constexpr double kStep = 1e-5;
  ForPointsInView([&](const Eigen::Vector3d& point) {
    const auto analytic = DistortedByCoefficients(camera_, point.hnormalized());
    const auto& coefficients = LensCoefficients(camera_.lens);
    ASSERT_EQ(analytic.cols(), static_cast<Eigen::Index>(coefficients.size()));
    for (size_t i = 0; i < coefficients.size(); ++i) {
      std::array<Eigen::Vector2d, 2> moved;
      for (const int side : {0, 1}) {
        Camera camera = camera_;
        camera.*coefficients[i].value += side == 0 ? -kStep : kStep;
        Eigen::Matrix2d jacobian;
        ASSERT_TRUE(
            Distort(camera, point.hnormalized(), &moved[static_cast<size_t>(side)], &jacobian));
      }
      const Eigen::Vector2d numeric = (moved[1] - moved[0]) / (2 * kStep);
      EXPECT_LT((analytic.col(static_cast<Eigen::Index>(i)) - numeric).norm(), 1e-8)
          << coefficients[i].name << " " << point.transpose();
    }
  });
}

// Rays up to 88 degrees off the axis, where the wide models still see them.
TEST_P(Lens, FarRaysComeBackOrAreNotSeen) {
  const bool wide = GetParam().model != LensModel::kRadialTangential;
  int seen = 0;
  for (double degrees = 0; degrees < 88.5; degrees += 0.5) {
    const double angle = degrees * M_PI / 180;
    const Eigen::Vector3d ray(0.6 * std::sin(angle), -0.8 * std::sin(angle), std::cos(angle));
    Eigen::Vector2d pixel;
    if (!camera_.Project(ray, &pixel)) break;  // past a fold another branch may begin
    const auto back = camera_.Unproject(pixel);
    if (!back) continue;
    ++seen;
    EXPECT_LT((back->homogeneous().normalized() - ray).norm(), 1e-8) << degrees;
  }
  EXPECT_GT(seen, wide ? 130 : 40) << "steps of half a degree";
}

// Pixels far outside are seen by no ray, or by one that comes back there.
TEST_P(Lens, PixelsOffTheImageHaveTheirOwnRayOrNone) {
  int none = 0;
  for (double r = 0.1; r < 30; r *= 1.1) {
    const Eigen::Vector2d pixel(camera_.cx + r * camera_.fx, camera_.cy - 0.3 * r * camera_.fy);
    const auto ray = camera_.Unproject(pixel);
    none += ray ? 0 : 1;
    Eigen::Vector2d again;
    if (ray && camera_.Project(ray->homogeneous(), &again)) {
      EXPECT_LT((again - pixel).norm(), 1e-5 * r * camera_.fx) << r;
    }
  }
  EXPECT_GT(none, camera_.lens == LensModel::kRadialTangential ? -1 : 5);
}

TEST(Camera, LensesOutOfTheirRangeAreAProblem) {
  const auto problem = [](LensModel model, const std::vector<double>& k) {
    return MakeCamera({"", model, k}).Problem().value_or("");
  };
  EXPECT_EQ(problem(LensModel::kDoubleSphere, {-0.2, 0.59}), "");
  EXPECT_EQ(problem(LensModel::kDoubleSphere, {-1, 0.5}), "xi: expected more than -1, got -1");
  EXPECT_EQ(problem(LensModel::kDoubleSphere, {0, 1.5}), "alpha: expected 0..1, got 1.5");
  EXPECT_EQ(problem(LensModel::kExtendedUnified, {0.5, 0}), "beta: expected > 0, got 0");
  EXPECT_EQ(problem(LensModel::kFieldOfView, {0}),
            "w: expected 0.001..3.14 rad (the lens's field of view), got 0");
  EXPECT_EQ(problem(LensModel::kOmni, {NAN}), "expected finite intrinsics");
}

// xi makes the image of a double sphere smaller than its focal length says.
TEST(Camera, FocalLengthOnTheAxisIsWhatTheImageMovesBy) {
  for (const NamedLens& lens : {NamedLens{"", LensModel::kDoubleSphere, {-0.2, 0.59}},
                                NamedLens{"", LensModel::kOmni, {0.99, 0, 0, 0, 0}},
                                NamedLens{"", LensModel::kFieldOfView, {0.9}},
                                NamedLens{"", LensModel::kRadialTangential, {-0.3}}}) {
    const Camera camera = MakeCamera(lens);
    Eigen::Vector2d pixel;
    ASSERT_TRUE(camera.Project({1e-6, 0, 1}, &pixel));
    EXPECT_NEAR((pixel.x() - camera.cx) / 1e-6, FocalLengthOnAxis(camera), 1e-4);
  }
}

TEST(Camera, EquidistantSeesUpTo89Degrees) {
  Camera camera = MakeCamera({"", LensModel::kEquidistant, {0.01, -0.002, 0, 0}});
  for (const double angle : {1e-12, 1e-6, 0.5, 1.2, 1.5}) {
    const Eigen::Vector3d point(0.6 * std::sin(angle), 0.8 * std::sin(angle), std::cos(angle));
    Eigen::Vector2d pixel;
    ASSERT_TRUE(camera.Project(point, &pixel));
    const auto ray = camera.Unproject(pixel);
    ASSERT_TRUE(ray) << angle;
    EXPECT_LT((ray->homogeneous().normalized() - point).norm(), 1e-10) << angle;
  }
  EXPECT_FALSE(camera.Unproject({camera.cx + 1.6 * camera.fx, camera.cy}));
}

// Beyond its fold a lens model maps far points back into the image.
TEST(Camera, PointsPastTheFoldAreNotSeen) {
  const Camera radtan = MakeCamera({"", LensModel::kRadialTangential, {-0.4, 0, 0, 0}});
  const Camera equidistant = MakeCamera({"", LensModel::kEquidistant, {-0.4, 0, 0, 0}});
  for (const Camera& camera : {radtan, equidistant}) {
    Eigen::Vector2d pixel(-1, -1);
    EXPECT_TRUE(camera.Project({0.5, 0, 1}, &pixel));
    EXPECT_FALSE(camera.Project({1.5, 0, 1}, &pixel));
    EXPECT_FALSE(camera.Unproject({camera.cx + 5 * camera.fx, camera.cy}));
  }
}

// This one folds at r = 1.2 and again at 2.2: the far branch covers the image a second time.
TEST(Camera, PixelsBeyondTheLensHaveNoRayOfTheFarBranch) {
  const Camera camera = MakeCamera(
      {"", LensModel::kRadialTangential, {0.42, -0.21, 8e-4, -4e-4, 0.03, 0.71, -0.15, 0.06}});
  for (double angle = 0; angle < 6.28; angle += 0.01) {
    for (const double r : {0.5, 0.75, 0.85, 0.95, 1.3}) {
      const Eigen::Vector2d pixel(camera.cx + camera.fx * r * std::cos(angle),
                                  camera.cy + camera.fy * r * std::sin(angle));
      const auto ray = camera.Unproject(pixel);
      EXPECT_EQ(static_cast<bool>(ray), r < 0.8) << r << " " << angle;
      EXPECT_LT(ray.value_or(Eigen::Vector2d::Zero()).norm(), 1.2);
    }
  }
}

TEST(Camera, NotANumberIsAProblemInEveryCoefficient) {
  for (double Camera::*k : {&Camera::k1, &Camera::k3, &Camera::k4, &Camera::k5, &Camera::k6}) {
    Camera camera;
    camera.*k = NAN;
    EXPECT_TRUE(camera.Problem());
  }
  EXPECT_FALSE(Camera().Problem());
}

}  // namespace
}  // namespace tagtwist::internal::camera_test
