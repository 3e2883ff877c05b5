#pragma once
#include <array>
#include <utility>

#include "frontend/base/named_enum.h"

namespace tagtwist {

/// The trajectories of a run that summary.json tells the accuracy of, by their names there.
enum class ComparisonKey { kNone, kClosedForm, kOptimised, kOptimisedLagged };
template <>
struct EnumNames<ComparisonKey> {
  static constexpr std::array<std::pair<ComparisonKey, const char*>, 4> kAll = {
      {{ComparisonKey::kNone, ""},
       {ComparisonKey::kClosedForm, "closed_form"},
       {ComparisonKey::kOptimised, "optimised"},
       {ComparisonKey::kOptimisedLagged, "optimised_lagged"}}};
};

}  // namespace tagtwist
