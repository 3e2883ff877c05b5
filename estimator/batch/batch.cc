#include "estimator/batch/batch.h"

#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "estimator/batch/batch_audit.h"
#include "estimator/batch/batch_states.h"
#include "estimator/batch/first_solve.h"
#include "estimator/batch/gap_turns.h"
#include "estimator/batch/gaps.h"
#include "estimator/batch/imu/imu_stage.h"
#include "estimator/batch/model_choice.h"
#include "estimator/batch/open_accounts.h"
#include "estimator/batch/two_poses.h"
#include "estimator/batch/uneven_motion.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/reprojection.h"
#include "estimator/graph/track_segments.h"
#include "estimator/motion/motion_breaks.h"
#include "estimator/motion/repeated_images.h"
#include "estimator/motion/turn_or_move.h"
#include "estimator/result/tag_audit.h"
#include "estimator/rig/tags_at_stamp.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/noise_rounds.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/corner_scatter.h"
#include "estimator/start/doubled_tags.h"
#include "estimator/start/leaps.h"
#include "estimator/start/recording_start.h"
#include "estimator/start/set_up_check.h"
#include "estimator/start/steady_clock.h"
#include "frontend/base/spans.h"
#include "frontend/geometry/tag_gate.h"

namespace tagtwist {

using namespace internal;

class BatchEstimator::Impl {
 public:
  Impl(EstimatorSetup setup, SpanObserver* spans)
      : setup_(std::move(setup)),
        spans_(spans),
        segmenter_({setup_.options.max_tracks_per_frame, setup_.options.track_segment_frames}),
        set_up_check_(setup_),
        gate_(setup_.map, setup_.Cameras()) {}

  void Use(ImuRecord imu) {
    imu_ = std::move(imu);
    setup_.options.use_tracks = false;
  }
  void Add(FrameMeasurements measurement);
  Result<Estimate> Solve();

 private:
  using Measurements = std::vector<FrameMeasurements>;  // without their tracks

  // What else may be, as a solution shows that takes lone glimpses as they are: WaysWithoutTwins,
  // HasUnlikelyGlimpses. One without the unlikely ones follows a twin, and shows none.
  struct Ways {
    bool drops_glimpses = false;  // asked for
    std::vector<DoubledTags> without_twins;
    bool has_unlikely_glimpses = false;
  };
  // Without the tags that are left out.
  Result<Estimate> SolveWithout(const DoubledTags& doubled, Ways* ways) const;
  Result<Estimate> SolveRolling(const Measurements& measurements, const DoubledTags& doubled,
                                Ways* ways) const;
  Result<Estimate> SolveFor(const Measurements& measurements, const DoubledTags& doubled,
                            Ways* ways) const;
  // With an IMU or by tags alone.
  Result<Estimate> SolveBy(const std::optional<ImuRecord>& imu, const Measurements& measurements,
                           const DoubledTags& doubled, Ways* ways) const;

  // Solves and learns, again and again without the tags that the solution contradicts. Leaves in
  // `input` the states and the tags that were used, in `open` what these leave open.
  Result<Solution> SolveWithTrustedTags(const Measurements& measurements,
                                        const std::vector<int>& state_of_frame,
                                        const std::vector<FrameRange>& gaps, GraphInput* input,
                                        NoiseModel* noise, std::vector<OpenAccounts>* open,
                                        Ways* ways) const;
  EstimatorSetup setup_;
  SpanObserver* spans_;
  std::optional<ImuRecord> imu_;
  TrackSegmenter segmenter_;
  RigCheck set_up_check_;
  Status set_up_is_right_ = Ok();  // as far as the frames say
  TagGate gate_;
  RepeatedImages repeated_;
  DoubledTags doubled_;
  Measurements measurements_;  // without the tags that
  TagsByFrame refused_;        // the gate refused
  std::vector<int> n_tracks_;
  std::vector<std::vector<double>> misfits_px_;  // of the tags of each frame (CornerScatter)
};

void BatchEstimator::Impl::Add(FrameMeasurements measurement) {
  repeated_.TakeOut(&measurement);
  segmenter_.Add(measurement.tracks, static_cast<int>(measurement.tags.size()),
                 measurement.cameras);
  n_tracks_.push_back(static_cast<int>(measurement.tracks.size()));
  measurement.tracks = {};
  doubled_.Add(measurement);
  if (set_up_is_right_) set_up_is_right_ = set_up_check_.Add(measurement.tags);
  auto refused = gate_.TakeRefused(&measurement.tags, &misfits_px_.emplace_back());
  if (!IsJudgedByShape(setup_, measurement.tags)) misfits_px_.back().clear();
  if (!refused.empty()) refused_.emplace(measurements_.size(), std::move(refused));
  measurements_.push_back(std::move(measurement));
}

Result<Solution> BatchEstimator::Impl::SolveWithTrustedTags(const Measurements& measurements,
                                                            const std::vector<int>& state_of_frame,
                                                            const std::vector<FrameRange>& gaps,
                                                            GraphInput* input, NoiseModel* noise,
                                                            std::vector<OpenAccounts>* open,
                                                            Ways* ways) const {
  const SolveOptions options{setup_.options.max_iterations, 0};
  // Decides between ways that the measurements leave open.
  const auto decide = [&](Result<Solution> solution) {
    if (solution) {
      solution = DecideTwoPoses(setup_, options, std::move(*solution), input, noise, open);
    }
    std::vector<OpenAccounts> in_gaps;
    if (solution) {
      solution = DecideGaps(setup_, options, gaps, std::move(*solution), input, noise, &in_gaps);
    }
    std::move(in_gaps.begin(), in_gaps.end(), std::back_inserter(*open));
    return solution;
  };
  auto solution = decide(SolveFromStarts(setup_, options, input, noise));
  if (!solution) return solution;
  const auto seen = TagsOfStates(measurements, state_of_frame, input->frames.size());
  // What is left out may have misled a start or hidden another fault: until nothing changes.
  constexpr int kMaxRounds = 4;
  for (int round = 0; round < kMaxRounds; ++round) {
    const bool readmit = round == 0;
    const bool is_revised =
        ReviseTags(setup_, *noise, solution->graph, seen, readmit, &input->frames);
    const bool is_beyond = DropBeyondReach(&input->frames);
    const bool is_unlikely = ways->drops_glimpses && DropUnlikelyGlimpses(setup_, &input->frames);
    if (!is_revised && !is_beyond && !is_unlikely) break;
    *solution = Solution();  // its memory is for the next
    solution = SolveAndLearn(setup_, options, input, noise);
    if (!solution) return solution;
  }
  ways->has_unlikely_glimpses = HasUnlikelyGlimpses(setup_, input->frames);
  solution = LetMotionVary(setup_, options, std::move(*solution), input, noise);
  return decide(std::move(solution));
}

Result<Estimate> BatchEstimator::Impl::SolveFor(const Measurements& measurements,
                                                const DoubledTags& doubled, Ways* ways) const {
  auto out = SolveBy(imu_, measurements, doubled, ways);
  if (!out || !out->imu) return out;
  Ways none;
  none.drops_glimpses = ways->drops_glimpses;
  if (auto by_tags = SolveBy({}, measurements, doubled, &none)) {
    TakeSurer(std::move(*by_tags), &*out);
  }
  return out;
}

Result<Estimate> BatchEstimator::Impl::SolveBy(const std::optional<ImuRecord>& imu,
                                               const Measurements& measurements,
                                               const DoubledTags& doubled, Ways* ways) const {
  Stages stages(spans_);
  stages.Next("start");
  auto starts = StartFrames(setup_, measurements);
  if (!starts) return starts.error();
  Estimate out;
  out.noise = InitialNoise(setup_.options);
  const std::optional<SteadyClock> clock = ChooseClock(setup_, *starts, &out.noise);
  if (clock) TakeAtTimes(clock->t_ns, &*starts);
  const std::optional<std::string> of_breaks = MarkBreaks(setup_, &*starts);
  out.noise = ChooseNoise(setup_, *starts, out.noise);
  std::vector<int> state_of_frame = StatesOfFrames(setup_, *starts, segmenter_.segments());
  GraphInput input = InputOfStates(state_of_frame, segmenter_.segments(), &*starts);
  const std::vector<FrameRange> gaps = FindAndBridgeGaps(out.noise, &state_of_frame, &input);
  TrackTally tracks = TallyOf(input.segments);
  std::vector<OpenAccounts> open;
  stages.Next("solve");
  auto solution =
      SolveWithTrustedTags(measurements, state_of_frame, gaps, &input, &out.noise, &open, ways);
  if (!solution) return solution.error();

  if (imu) stages.Next("imu");
  const std::vector<Eigen::VectorXd> of_imu = TakeImu(
      setup_, imu, measurements, *starts, {&state_of_frame, &open, &input, &*solution}, &out);
  stages.Next("covariance");
  std::vector<StateCovariance> covariances =
      out.imu ? BodyCovariances(solution->covariance)
              : StateCovariances(setup_, out.noise, input.frames, *solution);
  out.trajectory =
      MakeTrajectory(solution->graph.states, std::move(solution->covariance), out.noise);
  AddSharedErrors(of_imu, &out.trajectory, &covariances);
  const std::vector<bool> ambiguous = CoverOpenAccounts(open, &out.trajectory, &covariances);
  out.systematic = AddSystematic(setup_, out.noise, solution->graph, input.frames, &out.trajectory,
                                 &covariances);
  if (out.imu) Widen(out.systematic.common_rotation_rad, &*out.imu);
  *solution = Solution();  // its memory is for the rows
  stages.Next("rows");
  PutBack(state_of_frame, out.trajectory, &input, &*starts);
  const std::vector<FrameRange> around = StatesAround(out.trajectory.states, *starts);
  const SolvedFrames solved{measurements, *starts, state_of_frame};
  const TagAudit audit = AuditTags(setup_, solved, refused_, &out);
  for (std::string& warning : doubled.Warnings()) out.warnings.push_back(std::move(warning));
  ways->without_twins = WaysWithoutTwins(setup_, solved, doubled);
  FillFrames(setup_, solved, covariances, n_tracks_, clock, &out);
  TellAmbiguous(ambiguous, around, &out.frames);
  for (std::string& warning : audit.Warnings()) out.warnings.push_back(std::move(warning));
  tracks.contradicted = tracks.used - TallyOf(input.segments).used;
  if (const auto of_tracks = tracks.Warning()) out.warnings.push_back(*of_tracks);
  if (clock) out.warnings.push_back(TextOf(*clock));
  if (of_breaks) out.warnings.push_back(*of_breaks);
  if (const auto of_repeated = repeated_.Warning()) out.warnings.push_back(*of_repeated);
  if (out.noise.lever_m > 0) out.warnings.push_back(TextOfUntold(out.noise.lever_m));
  return out;
}

Result<Estimate> BatchEstimator::Impl::Solve() {
  if (!set_up_is_right_) return set_up_is_right_.error();
  if (const auto fine = set_up_check_.Finish(); !fine) return fine.error();
  Ways ways, none, strict;
  strict.drops_glimpses = true;
  WidenScattered(misfits_px_, &measurements_);
  auto out = SolveWithout(doubled_, &ways);
  // Of twins that are never in one frame only the solution tells: it is made again without them.
  constexpr double kNoBetter = 1.2;  // than with the twins, which then are none
  double least = out ? kNoBetter * LargestJolt(out->frames) : 0;
  bool has_twins = false;
  for (const DoubledTags& way : ways.without_twins) {
    auto without = SolveWithout(way, &none);
    if (!without) continue;
    const double jolt = LargestJolt(without->frames);
    if (!(jolt < least)) continue;
    least = jolt;
    out = std::move(without);
    has_twins = true;
  }
  if (has_twins || !ways.has_unlikely_glimpses) return out;
  auto without_glimpses = SolveWithout(doubled_, &strict);
  return without_glimpses ? std::move(without_glimpses) : std::move(out);
}

Result<Estimate> BatchEstimator::Impl::SolveWithout(const DoubledTags& doubled, Ways* ways) const {
  if (!doubled.any()) return SolveRolling(measurements_, doubled, ways);
  Measurements single = measurements_;
  for (FrameMeasurements& frame : single) doubled.TakeOut(&frame.tags);
  return SolveRolling(single, doubled, ways);
}

// Under a rolling shutter again, with the corners as of the stamps.
Result<Estimate> BatchEstimator::Impl::SolveRolling(const Measurements& measurements,
                                                    const DoubledTags& doubled, Ways* ways) const {
  auto out = SolveFor(measurements, doubled, ways);
  // First by poses that are those of the mean row, then by those of the stamps.
  for (const bool of_stamp : {false, true}) {
    if (!out || !setup_.HasRollingShutter()) return out;
    Measurements of_stamps = measurements;
    for (FrameMeasurements& frame : of_stamps) {
      const int64_t delay_ns = of_stamp ? 0 : MeanDelayNs(setup_, frame.tags);
      const auto motion = MotionOfRows(setup_, frame.t_ns - delay_ns,
                                       [&](int64_t t_ns) { return out->trajectory.At(t_ns); });
      if (motion) frame.tags = TagsAsOfStamp(setup_, *motion, std::move(frame.tags));
    }
    out = Estimate();  // its memory is for the next
    out = SolveFor(of_stamps, doubled, ways);
  }
  return out;
}

BatchEstimator::BatchEstimator(const SetUp& set_up, const EstimatorOptions& options,
                               ForRanges for_ranges, SpanObserver* spans) {
  EstimatorSetup setup = MakeEstimatorSetup(set_up, options);
  setup.for_ranges = std::move(for_ranges);
  impl_ = std::make_unique<Impl>(std::move(setup), spans);
}

BatchEstimator::BatchEstimator(BatchEstimator&&) noexcept = default;
BatchEstimator& BatchEstimator::operator=(BatchEstimator&&) noexcept = default;
BatchEstimator::~BatchEstimator() = default;

void BatchEstimator::Use(ImuRecord imu) { impl_->Use(std::move(imu)); }

void BatchEstimator::Add(FrameMeasurements measurement) { impl_->Add(std::move(measurement)); }

Result<Estimate> BatchEstimator::Solve() const { return impl_->Solve(); }

Result<Estimate> RunBatch(const SetUp& set_up, const EstimatorOptions& options,
                          const std::vector<FrameMeasurements>& measurements) {
  BatchEstimator batch(set_up, options);
  for (const FrameMeasurements& m : measurements) batch.Add(m);
  return batch.Solve();
}

}  // namespace tagtwist
