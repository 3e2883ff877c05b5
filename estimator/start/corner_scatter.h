#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// How far corners scatter whose detector says nothing of it, frame by frame: light, motion and
/// distance change that within a recording. What the tags' shapes say, their distances from the
/// nearest squares (TagGate), is known before any pose. Levels of a coordinate's deviation, a
/// quarter of an octave apart, between which the frames may switch rarely: a hidden Markov model,
/// of which each frame knows the past. Where frames are likelier so, beyond doubt, than with one
/// level for all, and one lies well above what the recording usually has, the difference becomes
/// the corners' own covariance, and half of the usual in all frames; the rest is learned by the
/// solution, as ever.
class CornerScatter {
 public:
  CornerScatter();

  /// The variance of a corner's coordinate [px^2] in the next frame, by its tags' misfits [px] and
  /// those before. A misfit of 0 tells nothing.
  double Add(const std::vector<double>& misfits_px);
  /// The same frames come once more.
  void ForgetCounts();
  /// Gives a frame's tags, of that variance and with these misfits, what goes beyond the usual so
  /// far as their own covariance, and more to one whose shape lies off by far: as much as its
  /// misfit says. Without misfits it leaves them as they are.
  void Widen(double variance_px2, const std::vector<double>& misfits_px,
             std::vector<TagDetection>* tags) const;

 private:
  static constexpr size_t kLevels = 37;

  using Levels = std::array<double, kLevels>;

  void Compare(const Levels& logs);
  double UsualPx2() const;
  bool IsUnusual(double variance_px2) const;

  Levels weights_, frames_at_ = {};  // now; and frames so far
  Levels even_;                      // weights, were it one level for all frames
  double advantage_ = 0;             // over that, logarithm of the latest frames' likelihoods
  bool is_uneven_ = false;           // the advantage was clear once
  size_t tags_ = 0;                  // so far
};

/// Whether the shapes are what these tags are judged by: not where they have a covariance of their
/// own, nor where the setup has a deviation, nor under a rolling shutter, which bends shapes.
bool IsJudgedByShape(const EstimatorSetup& setup, const std::vector<TagDetection>& tags);

/// All frames of a recording, each by what is usual in all of it.
void WidenScattered(const std::vector<std::vector<double>>& misfits_px,
                    std::vector<FrameMeasurements>* frames);

}  // namespace tagtwist::internal
