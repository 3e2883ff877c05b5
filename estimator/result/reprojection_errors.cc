#include "estimator/result/reprojection_errors.h"

namespace tagtwist {

void RegionErrors::CloseBlock() {
  for (RatioStatistic* statistic : {&squares, &u, &v}) statistic->CloseBlock();
}

void TagErrors::CloseBlock() {
  for (RatioStatistic* statistic : {&squares, &x_m, &y_m, &px_per_m}) statistic->CloseBlock();
}

}  // namespace tagtwist
