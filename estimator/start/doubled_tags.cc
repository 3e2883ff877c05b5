#include "estimator/start/doubled_tags.h"

#include <algorithm>

#include "frontend/base/format_text.h"

namespace tagtwist::internal {

void DoubledTags::History::AddRight() {
  ++seen;
  in_a_row = 0;
}

bool DoubledTags::History::AddWrong() {
  constexpr int kInARow = 5, kLeast = 8, kOneIn = 4;
  ++seen;
  ++wrong;
  ++in_a_row;
  return in_a_row >= kInARow || (wrong >= kLeast && kOneIn * wrong >= seen);
}

// Only what was wrong once is counted: a frame costs as much as there are such tags.
bool DoubledTags::Add(const FrameMeasurements& measurement) {
  const std::vector<int>& doubled = measurement.doubled_ids;
  for (const TagDetection& tag : measurement.tags) {
    const auto known = doubled_.find(tag.id);
    if (known == doubled_.end() || std::count(doubled.begin(), doubled.end(), tag.id) > 0) continue;
    known->second.AddRight();
  }
  bool tells = false;
  for (const int id : doubled) {
    if (doubled_[id].AddWrong() && left_out_.insert(id).second) tells = true;
  }
  return tells;
}

void DoubledTags::AddSolved(const std::vector<int>& used, const std::vector<int>& elsewhere) {
  constexpr int kOften = 5;
  for (const int id : used) {
    if (used.size() > 1) ++agreed_[id];
    const auto known = moved_.find(id);
    if (known != moved_.end()) known->second.AddRight();
  }
  const bool is_known = used.size() > 1 || (used.size() == 1 && agreed_.count(used[0]) > 0 &&
                                            agreed_[used[0]] >= kOften);
  if (!is_known) return;
  for (const int id : elsewhere) {
    if (moved_[id].AddWrong()) left_out_.insert(id);
  }
}

void DoubledTags::TakeOut(std::vector<TagDetection>* tags) const {
  if (left_out_.empty()) return;
  tags->erase(std::remove_if(tags->begin(), tags->end(),
                             [&](const TagDetection& tag) { return IsLeftOut(tag.id); }),
              tags->end());
}

std::vector<std::string> DoubledTags::Warnings() const {
  std::vector<std::string> out;
  for (const int id : left_out_) {
    const auto doubled = doubled_.find(id);
    const auto moved = moved_.find(id);
    if (doubled != doubled_.end() && doubled->second.wrong > 0) {
      out.push_back(Format(
          "tag %d is seen at two places at once in %d frames: two tags have that id, and which is "
          "the map's cannot be told; none is used: cover one or give it another id",
          id, doubled->second.wrong));
    } else if (moved != moved_.end()) {
      out.push_back(Format(
          "tag %d is seen elsewhere than the tags beside it say in %d frames: it was moved, or "
          "another has its id; it is not used",
          id, moved->second.wrong));
    }
  }
  return out;
}

}  // namespace tagtwist::internal
