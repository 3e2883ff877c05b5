#pragma once
#include <Eigen/Core>
#include <vector>

namespace tagtwist::internal {

/// Data about parameters that have a linear effect on whitened residuals r = F x + n, all else
/// eliminated: F'F, F'r, r'r, and how many residuals are left.
struct LinearEvidence {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double square_sum = 0;
  double dof = 0;
};

/// Parameters side by side that share a prior: zero mean, one variance, independent.
struct ParameterGroup {
  int first = 0, size = 0;
  double sigma = 0;  // of each; where the search starts, and its result: 0 where the data show none
  bool is_given = false;   // known: the search leaves it as it is
  double least = 0;        // the search does not go below it
  bool comes_back = true;  // where others stay, as far as the data do not speak against it
};

/// What the data say of all parameters.
struct EvidenceFit {
  std::vector<ParameterGroup> groups;
  double noise_scale = 1;  // standard deviation of n
  Eigen::VectorXd mean;
  Eigen::MatrixXd root;     // parameters x k: of their covariance, root root'
  double log_evidence = 0;  // up to a constant of the data

  bool IsEmpty() const;  // no group is left
};

/// Variances of the groups and of the noise by their evidence (type-II maximum likelihood, by
/// MacKay's fixed point: Bayesian Interpolation, 1992, Eq. 4.4 to 4.9). A group without which the
/// evidence falls by less than what chance brings once in a thousand is left out; where others that
/// are not given stay it gets back as much of its sigma at the start, halved at most six times, as
/// the data do not speak against.
EvidenceFit FitByEvidence(const LinearEvidence& data, std::vector<ParameterGroup> groups);

}  // namespace tagtwist::internal
