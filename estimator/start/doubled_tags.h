#pragma once
#include <map>
#include <set>
#include <string>
#include <vector>

#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Ids of the map that more than one tag has: seen at two places of one frame, or elsewhere than
/// the tags beside it say, in five frames running of those that show it, or in a quarter of them,
/// eight at least, since the first. A lone one of the two may be either, and would put the body
/// surely elsewhere: none is used any more. A phantom that has a true tag's id in a frame now and
/// then takes nothing from that tag.
class DoubledTags {
 public:
  /// The next frame. True where it told of an id that is left out from now on.
  bool Add(const FrameMeasurements& measurement);
  /// What a frame's solution was made with, and the ids that it shows elsewhere. These count where
  /// two were used, or one that has agreed with another in five frames: of two that never agree
  /// nobody knows which is right.
  void AddSolved(const std::vector<int>& used, const std::vector<int>& elsewhere);
  /// Whether tags have ever agreed with one another.
  bool any_agreed() const { return !agreed_.empty(); }
  bool IsLeftOut(int id) const { return left_out_.count(id) > 0; }
  bool any() const { return !left_out_.empty(); }
  /// Takes them out of a frame's tags.
  void TakeOut(std::vector<TagDetection>* tags) const;
  /// One line each.
  std::vector<std::string> Warnings() const;

 private:
  struct History {
    int seen = 0, wrong = 0;  // frames
    int in_a_row = 0;         // wrong, the latest that showed it

    void AddRight();
    bool AddWrong();  // true where that is a rule
  };
  std::map<int, History> doubled_, moved_;  // by id
  std::map<int, int> agreed_;               // in frames
  std::set<int> left_out_;
};

}  // namespace tagtwist::internal
