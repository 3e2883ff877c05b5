#include "frontend/tags/guided_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <random>

#include "tests/support/flights/flight_scene.h"

namespace tagtwist::internal::guided_detector_test {
namespace {

constexpr double kBorderPx = 4;

// The mat with two ids exchanged.
TagMap Renamed(int from, int to) {
  const TagMap map = MakeTagMap({});
  std::vector<Tag> tags = map.tags();
  for (Tag& tag : tags) {
    if (tag.id == from) {
      tag.id = to;
    } else if (tag.id == to) {
      tag.id = from;
    }
  }
  return TagMap(map.family(), tags);
}

struct View {
  SimulatedFrame frame;
  std::vector<TagDetection> truth;  // the tags that lie in the image
};

View MakeView(double t_s = 3) {
  SimulatorOptions options;
  options.corner_noise_px = 0;
  const TagMap map = MakeTagMap({});
  const RenderedFlight flight = MakeRenderedFlight("figure8", map, options);
  View out{flight.simulator.MakeFrame(0, flight.StampAt(t_s)), {}};
  for (const TagDetection& tag : out.frame.detections) {
    if (std::all_of(tag.corners.begin(), tag.corners.end(),
                    [](const auto& c) { return Camera().Contains(c, kBorderPx); })) {
      out.truth.push_back(tag);
    }
  }
  std::sort(out.truth.begin(), out.truth.end(),
            [](const auto& a, const auto& b) { return a.id < b.id; });
  EXPECT_GE(out.truth.size(), 6U);
  return out;
}

// The truth moved by a random draw from the covariance that the prediction states.
PosePrediction Predict(const View& view, double sigma_rad, double sigma_m, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal(0, 1);
  Eigen::Vector3d theta, rho;
  for (int i = 0; i < 3; ++i) {
    theta[i] = sigma_rad * normal(engine);
    rho[i] = sigma_m * normal(engine);
  }
  const Pose& truth = view.frame.truth.world_from_body;
  PosePrediction out;
  out.world_from_body = MakePose(truth.rotation() * ExpSo3(theta), truth.translation() + rho);
  out.covariance.diagonal() << Eigen::Vector3d::Constant(sigma_rad * sigma_rad),
      Eigen::Vector3d::Constant(sigma_m * sigma_m);
  return out;
}

struct Finder {
  std::shared_ptr<const CornerRefiner> refiner;  // shared by copies
  GuidedDetector detector;

  explicit Finder(const TagMap& map = MakeTagMap({}))
      : refiner(std::make_shared<CornerRefiner>(std::move(*CornerRefiner::Create(map, Camera())))),
        detector(Camera(), CourseCamFromBody(), map, kBorderPx) {}
  GuidedTags Find(const cv::Mat& image, const PosePrediction& prediction) {
    return detector.Find(image, *refiner, prediction);
  }
};

double WorstCornerPx(const std::vector<TagDetection>& found,
                     const std::vector<TagDetection>& truth) {
  double worst = 0;
  for (const TagDetection& tag : found) {
    const auto same = std::find_if(truth.begin(), truth.end(),
                                   [&](const auto& other) { return other.id == tag.id; });
    if (same == truth.end()) return 1e9;
    for (size_t c = 0; c < 4; ++c) {
      worst = std::max(worst, (tag.corners[c] - same->corners[c]).norm());
    }
  }
  return worst;
}

TEST(GuidedDetector, FindsEveryTagFromGoodAndFromRoughPredictions) {
  const View view = MakeView();
  for (const double sigma_px : {0.1, 0.5, 1.5}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      Finder finder;
      const double sigma_m = sigma_px * 1.2 / 311;
      const auto prediction = Predict(view, sigma_px / 311, sigma_m, seed);
      const GuidedTags first = finder.Find(view.frame.image, prediction);
      EXPECT_EQ(first.found.size(), view.truth.size()) << sigma_px << " px, seed " << seed;
      EXPECT_LT(WorstCornerPx(first.found, view.truth), 0.1) << sigma_px << " px, seed " << seed;
      // Again, now that their looks are known.
      const GuidedTags again = finder.Find(view.frame.image, prediction);
      ASSERT_EQ(again.found.size(), first.found.size());
      for (size_t i = 0; i < again.found.size(); ++i) {
        for (size_t c = 0; c < 4; ++c) {
          EXPECT_LT((again.found[i].corners[c] - first.found[i].corners[c]).norm(), 0.005);
        }
      }
    }
  }
}

TEST(GuidedDetector, AnotherTagInItsPlaceIsNotBelieved) {
  const View view = MakeView();
  for (size_t i = 0; i < view.truth.size(); ++i) {
    const int id = view.truth[i].id;
    for (const int other : {(id + 1) % 108, (id + 12) % 108, (id + 50) % 108}) {
      Finder finder(Renamed(id, other));
      for (int round = 0; round < 2; ++round) {
        const auto tags = finder.Find(view.frame.image, Predict(view, 1e-3, 1e-3, 7)).found;
        EXPECT_GE(tags.size() + 2, view.truth.size());
        for (const TagDetection& tag : tags) {
          EXPECT_NE(tag.id, id);
          EXPECT_NE(tag.id, other);
        }
      }
    }
  }
}

TEST(GuidedDetector, AKidnappedCameraSeesNothingWhereItBelievesToBe) {
  const View view = MakeView();
  Finder finder;
  finder.Find(view.frame.image, Predict(view, 1e-3, 1e-3, 1));  // looks are known
  for (const Eigen::Vector3d& away :
       {Eigen::Vector3d(0.304, 0, 0), Eigen::Vector3d(0, -0.304, 0), Eigen::Vector3d(0.07, 0.05, 0),
        Eigen::Vector3d(0.608, 0.304, 0.1)}) {
    PosePrediction wrong = Predict(view, 1e-3, 1e-3, 1);
    wrong.world_from_body =
        MakePose(wrong.world_from_body.rotation(), wrong.world_from_body.translation() + away);
    EXPECT_TRUE(Finder(finder).Find(view.frame.image, wrong).found.empty()) << away.transpose();
  }
}

TEST(GuidedDetector, ACoveredTagIsLeftOutAndComesBack) {
  const View view = MakeView();
  Finder finder;
  const auto prediction = Predict(view, 1e-3, 1e-3, 3);
  finder.Find(view.frame.image, prediction);
  for (const int grey : {0, 128, 255}) {
    cv::Mat covered = view.frame.image.clone();
    const TagDetection& tag = view.truth[2];
    const cv::Rect box = cv::boundingRect(std::vector<cv::Point2f>{
        {static_cast<float>(tag.corners[0].x()), static_cast<float>(tag.corners[0].y())},
        {static_cast<float>(tag.corners[1].x()), static_cast<float>(tag.corners[1].y())},
        {static_cast<float>(tag.corners[2].x()), static_cast<float>(tag.corners[2].y())},
        {static_cast<float>(tag.corners[3].x()), static_cast<float>(tag.corners[3].y())}});
    covered(box & cv::Rect(0, 0, covered.cols, covered.rows)) = grey;
    const GuidedTags without = finder.Find(covered, prediction);
    EXPECT_EQ(without.found.size() + 1, view.truth.size()) << grey;
    for (const TagDetection& found : without.found) EXPECT_NE(found.id, tag.id) << grey;
    EXPECT_EQ(finder.Find(view.frame.image, prediction).found.size(), view.truth.size()) << grey;
  }
}

TEST(GuidedDetector, ALampThatGoesOnLosesNoTag) {
  const View view = MakeView();
  Finder finder;
  const auto prediction = Predict(view, 1e-3, 1e-3, 3);
  finder.Find(view.frame.image, prediction);
  cv::Mat brighter;
  view.frame.image.convertTo(brighter, -1, 0.6, 40);
  EXPECT_EQ(finder.Find(brighter, prediction).found.size(), view.truth.size());
}

TEST(GuidedDetector, NothingIsFoundInEmptyImages) {
  const View view = MakeView();
  const auto prediction = Predict(view, 1e-3, 1e-3, 3);
  Finder finder;
  for (int round = 0; round < 2; ++round) {
    for (const int grey : {0, 77, 255}) {
      const cv::Mat flat(view.frame.image.size(), CV_8UC1, cv::Scalar(grey));
      EXPECT_TRUE(Finder(finder).Find(flat, prediction).found.empty());
      EXPECT_GT(Finder(finder).Find(flat, prediction).expected, 5);
    }
    EXPECT_TRUE(Finder(finder).Find(cv::Mat(), prediction).found.empty());
    finder.Find(view.frame.image, prediction);  // looks are known in the second round
  }
  PosePrediction nowhere = prediction;
  nowhere.covariance.setConstant(NAN);
  EXPECT_TRUE(finder.Find(view.frame.image, nowhere).found.empty());
  nowhere = prediction;
  nowhere.covariance *= 1e6;
  EXPECT_TRUE(finder.Find(view.frame.image, nowhere).found.empty()) << "too uncertain to guide";
}

}  // namespace
}  // namespace tagtwist::internal::guided_detector_test
