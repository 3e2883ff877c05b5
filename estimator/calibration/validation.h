#pragma once
#include <vector>

#include "estimator/calibration/problem.h"
#include "estimator/calibration/solver.h"

namespace tagtwist::internal {

/// What frames say of a calibration that was not fitted to them: their poses are free, everything
/// else is as it was fitted on the others.
struct HeldOutJudgement {
  std::vector<double> block_costs;                  // robust, half squares; one a block of frames
  double corner_sigma_px = 0;                       // robust (MAD) of a corner's coordinate
  double truth_median_m = 0, truth_median_rad = 0;  // distance from ground truth; 0 without any
};

/// Two folds of blocks in turn: fitted on the one, judged on the other, and the other way round.
/// Searches start from `start`.
HeldOutJudgement JudgeHeldOut(const CalibrationProblem& problem,
                              const std::vector<CalibrationParameter>& parameters,
                              const std::vector<CalibrationGroup>& groups,
                              const CalibrationState& start, const CalibrationNoise& noise,
                              int n_blocks);

/// Whether a group of parameters helps frames that it was not fitted to.
struct GroupVerdict {
  CalibrationGroup group = CalibrationGroup::kPinhole;
  bool applied = false;
  double gain = 0, gain_sigma = 0;  // of the held-out cost a block
};

struct CalibrationValidation {
  HeldOutJudgement given, refined;
  std::vector<GroupVerdict> verdicts;  // of every group with a free parameter
  std::vector<CalibrationGroup> applied() const;
};

/// Leaves out, one after the other, the group that helps least, until each one left lowers the
/// held-out cost by more than twice the standard error over the blocks. Groups of `kept` are
/// applied whatever they help.
CalibrationValidation ValidateGroups(const CalibrationProblem& problem,
                                     const std::vector<CalibrationParameter>& parameters,
                                     const CalibrationState& start, const CalibrationNoise& noise,
                                     int n_blocks, const std::vector<CalibrationGroup>& kept = {});

}  // namespace tagtwist::internal
