#include "estimator/start/doubled_tags.h"

#include <algorithm>

#include "frontend/base/format_text.h"

namespace tagtwist::internal {

void DoubledTags::History::AddRight() {
  ++seen;
  in_a_row = 0;
}

void DoubledTags::History::AddWrong() {
  ++seen;
  ++wrong;
  ++in_a_row;
}

bool DoubledTags::History::IsRun() const {
  constexpr int kInARow = 5;
  return in_a_row >= kInARow;
}

bool DoubledTags::History::IsOften() const {
  constexpr int kLeast = 8, kOneIn = 4;
  return wrong >= kLeast && kOneIn * wrong >= seen;
}

bool DoubledTags::History::IsAlways() const {
  constexpr int kLeast = 60;
  return wrong >= kLeast && 10 * wrong >= 9 * seen;
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
    History& history = doubled_[id];
    history.AddWrong();
    if ((history.IsRun() || history.IsOften()) && left_out_.insert(id).second) tells = true;
  }
  return tells;
}

// Of two that contradict each other nobody knows which is right: two others have to agree.
void DoubledTags::AddAside(const std::vector<int>& used, const std::vector<int>& aside) {
  if (used.size() < 2) return;
  for (auto& [id, history] : contradicted_) {
    if (used.size() > 2 && std::count(used.begin(), used.end(), id) > 0) history.AddRight();
  }
  for (const int id : aside) {
    History& history = contradicted_[id];
    history.AddWrong();
    if (history.IsAlways()) set_aside_.insert(id);
  }
}

void DoubledTags::AddSolved(const std::vector<int>& used,
                            const std::vector<TagElsewhere>& elsewhere,
                            const std::vector<int>& aside) {
  constexpr int kOften = 5, kNear = 90;
  ++frames_;
  AddAside(used, aside);
  since_gap_.insert(used.begin(), used.end());
  agreed_since_gap_ = agreed_since_gap_ || used.size() > 1;
  if (used.size() == 1 && !elsewhere.empty()) {
    for (const TagElsewhere& tag : elsewhere) {
      ++disputes_[used[0]][tag.id];
      ++disputes_[tag.id][used[0]];
    }
  }
  for (const int id : used) {
    if (used.size() > 1) ++agreed_[id];
    const auto known = moved_.find(id);
    if (known != moved_.end()) known->second.AddRight();
  }
  const bool is_known =
      used.size() > 1 || (used.size() == 1 && agreed_since_gap_ && agreed_.count(used[0]) > 0 &&
                          agreed_[used[0]] >= kOften);
  if (!is_known) return;
  for (const auto& [id, shift_m, size_m] : elsewhere) {
    History& history = moved_[id];
    const bool is_there = (shift_m - history.place_m).norm() < size_m;
    if (!is_there || frames_ - history.last > kNear) history.in_a_row = 0;
    history.last = frames_;
    history.place_m = shift_m;
    history.AddWrong();
    if (history.IsRun()) left_out_.insert(id);
  }
}

void DoubledTags::LoseTouch() {
  since_gap_.clear();
  agreed_since_gap_ = false;
}

void DoubledTags::StartAnew() {
  set_aside_.clear();
  contradicted_.clear();
}

bool DoubledTags::IsAtStake() const {
  constexpr int kByChance = 1;
  return !agreed_since_gap_ && std::any_of(since_gap_.begin(), since_gap_.end(), [&](int id) {
    const auto disputed = disputes_.find(id);
    if (disputed == disputes_.end()) return false;
    const auto& rivals = disputed->second;
    return std::any_of(rivals.begin(), rivals.end(), [&](const auto& rival) {
      return rival.second > kByChance && !IsLeftOut(rival.first);
    });
  });
}

void DoubledTags::LeaveOut(int id, int frames) {
  moved_[id].wrong += frames;
  left_out_.insert(id);
}

namespace {

void Erase(const std::set<int>& ids, std::vector<TagDetection>* tags) {
  if (ids.empty()) return;
  tags->erase(std::remove_if(tags->begin(), tags->end(),
                             [&](const TagDetection& tag) { return ids.count(tag.id) > 0; }),
              tags->end());
}

}  // namespace

void DoubledTags::TakeOut(std::vector<TagDetection>* tags) const { Erase(left_out_, tags); }
void DoubledTags::TakeOutAside(std::vector<TagDetection>* tags) const { Erase(set_aside_, tags); }

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

std::vector<std::string> DoubledTags::AsideWarnings() const {
  std::vector<std::string> out;
  for (const int id : set_aside_) {
    const History& history = contradicted_.at(id);
    out.push_back(
        Format("tag %d was contradicted by those beside it in %d frames of %d: it was moved, or is "
               "not flat; it is not used from there on",
               id, history.wrong, history.seen));
  }
  return out;
}

}  // namespace tagtwist::internal
