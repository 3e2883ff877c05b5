#include "frontend/base/nearest_name.h"

#include <gtest/gtest.h>

namespace tagtwist::internal::nearest_name_test {
namespace {

TEST(NearestName, FindsWhatWasMeant) {
  const std::vector<std::string> names = {"dataset", "output", "use_detections", "sliding_window"};
  EXPECT_EQ(NearestName("datset", names), "dataset");
  EXPECT_EQ(NearestName("use-detections", names), "use_detections");
  EXPECT_EQ(NearestName("uotput", names), "output");
  EXPECT_EQ(NearestName("sliding_windows", names), "sliding_window");
  EXPECT_EQ(DidYouMean("datset", names, "--"), ": did you mean --dataset?");
}

TEST(NearestName, GuessesNothingFarFetched) {
  const std::vector<std::string> names = {"fx", "fy", "width"};
  EXPECT_FALSE(NearestName("fz", names));  // as near to fx as to fy
  EXPECT_FALSE(NearestName("camera", names));
  EXPECT_FALSE(NearestName("x", {}));
  EXPECT_EQ(DidYouMean("camera", names), "");
}

TEST(NearestName, CountsEdits) {
  EXPECT_EQ(EditDistance("", "abc"), 3U);
  EXPECT_EQ(EditDistance("abc", "acb"), 1U);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3U);
}

}  // namespace
}  // namespace tagtwist::internal::nearest_name_test
