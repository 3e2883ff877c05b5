#include "estimator/systematic/lasting_errors.h"

#include <utility>

#include "estimator/systematic/systematic_errors.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kFirstTurn = 16;  // fewer frames say little of what lasts
constexpr size_t kMostKept = 128;

std::vector<int> IdsOf(const TagMap& map) {
  std::vector<int> out;
  for (const Tag& tag : map.tags()) out.push_back(tag.id);
  return out;
}

}  // namespace

LastingErrors::LastingErrors(const EstimatorSetup& setup)
    : setup_(setup),
      basis_(setup, IdsOf(setup.map)),
      are_given_(basis_.AnyIsGiven()),
      next_(kFirstTurn) {}

bool LastingErrors::Add(const NoiseModel& noise, int64_t t_ns, const BodyState& state,
                        const std::vector<TagDetection>& tags) {
  if (passed_++ % stride_ != 0) return false;
  GraphFrame& kept = frames_.emplace_back();
  kept.t_ns = t_ns;
  kept.state = state;
  kept.tags = tags;
  if (frames_.size() < next_) return false;
  const bool changed = Learn(noise);
  if (2 * frames_.size() <= kMostKept) {
    next_ = 2 * frames_.size();
  } else {  // every other one makes room
    for (size_t i = 0; 2 * i < frames_.size(); ++i) frames_[i] = std::move(frames_[2 * i]);
    frames_.resize((frames_.size() + 1) / 2);
    stride_ *= 2;
    next_ = kMostKept;
  }
  return changed;
}

bool LastingErrors::Learn(const NoiseModel& noise) {
  const SystematicBasis of_seen(setup_, TagsSeenMost(frames_));
  const SystematicErrors errors = LearnSystematicErrors(of_seen, noise, frames_);
  if (errors.None()) return std::exchange(root_, std::nullopt).has_value();
  root_ = basis_.RowsOf(of_seen, errors.root, errors.map ? &*errors.map : nullptr, errors.map_root);
  tag_sigma_m_ = errors.tag_sigma_m;
  unlearned_.clear();
  for (const Tag& tag : setup_.map.tags()) {
    if (of_seen.FirstOfTag(tag.id)) continue;
    for (int a = 0; a < 3; ++a) unlearned_.push_back(*basis_.FirstOfTag(tag.id) + a);
  }
  return true;
}

Eigen::MatrixXd LastingErrors::TimesRoot(const Eigen::MatrixXd& effects) const {
  if (!root_) return basis_.TimesGivenSigmas(effects);
  const auto others = static_cast<Eigen::Index>(unlearned_.size());
  Eigen::MatrixXd out(effects.rows(), root_->cols() + others);
  out.leftCols(root_->cols()) = effects * *root_;
  for (Eigen::Index i = 0; i < others; ++i) {
    out.col(root_->cols() + i) = tag_sigma_m_ * effects.col(unlearned_[static_cast<size_t>(i)]);
  }
  return out;
}

}  // namespace tagtwist::internal
