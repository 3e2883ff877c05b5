#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "estimator/graph/tag_elsewhere.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Ids of the map that more than one tag has: seen at two places of one frame, in five frames
/// running of those that show it, or in a quarter of them, eight at least, since the first; or seen
/// elsewhere than the tags beside it say, at one place, in five frames, each within ninety of the
/// one before. A lone one of the two may be either, and would put the body surely elsewhere: none
/// is used any more. Phantoms that have a tag's id now and then take nothing from that tag. Nor is
/// one used that two others or more have contradicted in nine of ten frames since the first, sixty
/// at least: it was moved, if by less than its size, and alone it would be believed.
class DoubledTags {
 public:
  /// The next frame. True where it told of an id that is left out from now on.
  bool Add(const FrameMeasurements& measurement);
  /// What a frame's solution was made with, and the tags that it shows elsewhere. These count where
  /// two were used, or one that has agreed with another in five frames: of two that never agree
  /// nobody knows which is right. `aside`: all that were seen and not used.
  void AddSolved(const std::vector<int>& used, const std::vector<TagElsewhere>& elsewhere,
                 const std::vector<int>& aside = {});
  /// No frame before is known to be near the next one: there was a gap, or the solution began anew.
  void LoseTouch();
  /// What the solution was until now may have been wrong: tags that it contradicted are used again.
  void StartAnew();
  /// Whether all that says where the body is since then are single tags, one of them of an id that
  /// has contradicted another, and neither is left out: one of twins would put it surely elsewhere.
  bool IsAtStake() const;
  /// Whether tags have ever agreed with one another.
  bool any_agreed() const { return !agreed_.empty(); }
  bool IsLeftOut(int id) const { return left_out_.count(id) + set_aside_.count(id) > 0; }
  bool any() const { return !left_out_.empty(); }
  /// Leaves that one out, which was wrong in so many frames.
  void LeaveOut(int id, int frames);
  /// Takes them out of a frame's tags; those that others contradict apart, of which an audit may
  /// still tell by how much.
  void TakeOut(std::vector<TagDetection>* tags) const;
  void TakeOutAside(std::vector<TagDetection>* tags) const;
  /// One line each.
  std::vector<std::string> Warnings() const;
  /// Of those that others contradict: by how much is the audit's to say.
  std::vector<std::string> AsideWarnings() const;

 private:
  struct History {
    int seen = 0, wrong = 0;                            // frames
    int in_a_row = 0;                                   // wrong, the latest that showed it
    int64_t last = 0;                                   // wrong one, counted among all frames,
    Eigen::Vector2d place_m = Eigen::Vector2d::Zero();  // and where it was

    void AddRight();
    void AddWrong();
    bool IsRun() const;
    bool IsOften() const;
    bool IsAlways() const;
  };
  void AddAside(const std::vector<int>& used, const std::vector<int>& aside);

  std::map<int, History> doubled_, moved_, contradicted_;  // by id
  std::map<int, int> agreed_;                              // in frames
  std::set<int> since_gap_;                                // that frames were solved with,
  bool agreed_since_gap_ = false;                          // none of which had two
  std::map<int, std::map<int, int>> disputes_;  // with another id and no third, in frames
  int64_t frames_ = 0;                          // with a solution
  std::set<int> left_out_, set_aside_;          // the latter until the solution begins anew
};

}  // namespace tagtwist::internal
