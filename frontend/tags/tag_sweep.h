#pragma once
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/camera_motion.h"
#include "frontend/tags/guided_detector.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {

/// An image of a recording: 8-bit gray, empty where there is none.
struct SweepImage {
  int64_t t_ns = 0;
  cv::Mat gray;
};

/// The usable tags of an image.
struct SweptTags {
  std::vector<TagDetection> tags;  // sorted by id
  std::vector<int> doubled_ids;
};

/// The usable tags of a piece of a recording, as FindTags finds them in each image, for a fraction
/// of its cost. The first image is searched with all that the options ask for; from there on each
/// tag is fitted where the camera's motion puts it, or where that is not known well enough, the
/// tags that show in the image halved. What this passes over (a tag that is not where the map has
/// it, one id at two places) is looked for in every eighth image, halved; where something shows,
/// every image since the last look is searched as the first one was, and those after it until
/// nothing is out of place. One thread at a time.
class TagSweep {
 public:
  /// The refiner is the caller's, and outlives this.
  static Result<TagSweep> Create(const SetUp& set_up, const TagDetectorOptions& options,
                                 const CornerRefiner& refiner);

  /// How many images of a camera are a piece: so many that the searches at its start cost little,
  /// and so few that they fit into some 64 MB.
  static size_t PieceLength(const Camera& camera);
  /// The same of frames in which all cameras of a rig have an image.
  static size_t PieceLength(const Rig& rig);

  /// Stamps grow. Nothing is kept from one piece to the next.
  std::vector<SweptTags> Find(const std::vector<SweepImage>& images);

 private:
  // What a search found, and of which tags the pattern was fitted.
  struct Searched {
    SweptTags found;
    RefinedTags refined;
  };
  // What tags say of the pose, and whether all of them are where it puts them.
  struct Judged {
    std::optional<PosePrediction> pose;
    bool is_clean = false;
  };
  TagSweep(const SetUp& set_up, const TagDetectorOptions& options, const CornerRefiner& refiner,
           TagDetector full, TagDetector coarse);
  // How the tags of an image are found: where the motion puts them, after a look at the whole of
  // it, or by searching it, since too few are or some that no pose explains.
  enum class Way { kFollowed, kLooked, kTooFew, kMore };
  Way FindGuided(const SweepImage& image, bool look, GuidedTags* guided);
  bool Guide(const cv::Mat& gray, const std::optional<PosePrediction>& from, GuidedTags* guided);
  bool MissesSeen(const cv::Mat& gray, const GuidedTags& guided) const;
  bool ShowsMore(const cv::Mat& gray, const std::vector<TagDetection>& shown,
                 const std::vector<TagDetection>& found) const;
  bool IsWhole(const cv::Mat& gray, const TagDetection& tag) const;
  Searched Search(const cv::Mat& gray) const;
  Judged Judge(const SweptTags& found, int64_t t_ns) const;
  SweptTags SearchAndLearn(const SweepImage& image);

  TagMap map_;
  Camera camera_;
  TagDetectorOptions options_;
  const CornerRefiner* refiner_;
  TagDetector full_detector_, coarse_detector_;
  GuidedDetector guided_;
  CameraMotion motion_;
  bool is_clean_ = false;  // all that the last image showed is where the map and the pose say
  std::vector<int> seen_;  // ids of the tags that were fitted in the last image
};

}  // namespace tagtwist::internal
