#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>

#include "apps/python/trajectory_arrays.h"
#include "estimator/report/html/comparison_report.h"
#include "frontend/io/trajectories/trajectory_file.h"

namespace tagtwist::internal::python {
namespace {

std::string PathOf(const py::object& object) {
  return object.cast<std::filesystem::path>().string();
}

// The trajectories of what compare() was given, and the truth that came with them.
ReadResults ToResults(const py::object& object, const Limits& limits) {
  ReadResults out;
  if (!py::isinstance<TrajectoryArrays>(object)) {
    if (!py::isinstance<py::str>(object) && !py::hasattr(object, "__fspath__")) {
      throw Refusal("estimate: expected a path, Estimate, States or Trajectory, got " +
                    Describe(object));
    }
    return TakeOrRaise(ReadResultsAt(PathOf(object), limits));
  }
  const auto& trajectory = object.cast<const TrajectoryArrays&>();
  if (!py::isinstance<StatesArrays>(object)) {
    out.series.push_back({"trajectory", ToSeries(trajectory)});
    return out;
  }
  const PoseSeries closed_form = ToSeries(object.cast<const StatesArrays&>().closed_form);
  if (!closed_form.empty()) out.series.push_back({"closed form", closed_form});
  const py::object lagged = py::getattr(object, "lagged", py::none());
  out.series.push_back({lagged.is_none() ? "optimised" : "optimised, lag 0", ToSeries(trajectory)});
  if (!lagged.is_none()) {
    out.series.push_back({"optimised, lagged", ToSeries(lagged.cast<const TrajectoryArrays&>())});
  }
  const py::object truth = py::getattr(object, "truth", py::none());
  if (!truth.is_none()) out.truth = ToTruth(truth.cast<const TrajectoryArrays&>());
  return out;
}

std::vector<TruthSample> TruthFrom(const py::object& object, const Limits& limits) {
  if (py::isinstance<TrajectoryArrays>(object)) {
    return ToTruth(object.cast<const TrajectoryArrays&>());
  }
  if (!py::isinstance<py::str>(object) && !py::hasattr(object, "__fspath__")) {
    throw Refusal("truth: expected a path or Trajectory, got " + Describe(object));
  }
  return TakeOrRaise(ReadGroundTruth(PathOf(object), limits));
}

EvaluationOptions ToOptions(const std::string& align, const py::object& time_offset_s,
                            double rpe_seconds, int rpe_frames, double rpe_metres) {
  EvaluationOptions out;
  const auto kind = ParseAlignmentKind(align);
  if (!kind) throw Refusal("align: expected none, se3 or handeye, got '" + align + "'");
  out.alignment.kind = *kind;
  if (py::isinstance<py::str>(time_offset_s)) {
    if (time_offset_s.cast<std::string>() != "estimate") {
      throw Refusal("time_offset_s: expected seconds or \"estimate\"");
    }
    out.alignment.estimate_time_offset = true;
  } else {
    out.alignment.time_offset_s = *ToArray(time_offset_s, "time_offset_s", {}).data();
  }
  if (!(rpe_seconds > 0)) throw Refusal("rpe_seconds: expected > 0");
  if (!(rpe_metres > 0)) throw Refusal("rpe_metres: expected > 0");
  if (rpe_frames < 1) throw Refusal("rpe_frames: expected >= 1");
  out.rpe_seconds = rpe_seconds;
  out.rpe_metres = rpe_metres;
  out.rpe_frames = static_cast<size_t>(rpe_frames);
  return out;
}

// {name: figures} of the JSON that tagtwist_compare writes.
py::dict FiguresByName(const std::string& json) {
  py::dict out;
  const py::object read = py::module_::import("json").attr("loads")(json);
  for (const py::handle& input : read["inputs"]) {
    py::dict figures = input["accuracy"];
    for (const char* key : {"frames", "alignment", "roughness"}) {
      if (input.contains(key)) figures[key] = input[key];
    }
    out[input["name"]] = figures;
  }
  return out;
}

py::dict CompareThem(const py::object& estimate, const py::object& truth, const std::string& align,
                     const py::object& time_offset_s, double rpe_seconds, int rpe_frames,
                     double rpe_metres, const LimitValues& limit_values) {
  const EvaluationOptions options =
      ToOptions(align, time_offset_s, rpe_seconds, rpe_frames, rpe_metres);
  const Limits limits = ToLimits(limit_values);
  ReadResults results = ToResults(estimate, limits);
  if (!truth.is_none()) results.truth = TruthFrom(truth, limits);
  if (results.truth.empty()) throw Refusal("truth: needed, for none came with the estimate");
  std::optional<Result<Comparison>> comparison;
  {
    const py::gil_scoped_release release;
    comparison = Compare(std::move(results.series), std::move(results.truth), "", options);
  }
  return FiguresByName(FormatComparisonJson(TakeOrRaise(std::move(*comparison))));
}

}  // namespace

void BindCompare(py::module_& module) {
  module.def("compare", &CompareThem, py::arg("estimate"), py::arg("truth") = py::none(),
             py::kw_only(), py::arg("align") = "none", py::arg("time_offset_s") = 0.0,
             py::arg("rpe_seconds") = 1.0, py::arg("rpe_frames") = 1, py::arg("rpe_metres") = 1.0,
             py::arg("limits") = py::none(),
             R"(Figures of trajectories against ground truth: tagtwist_compare as a call.

estimate       Estimate, States, Trajectory, or a path that tagtwist_compare takes
truth          Trajectory or path; None: what came with the estimate
align          "none"; "se3": the world moved rigidly onto the truth's; "handeye": besides, a
               rigid transform between the body and the frame that the truth measures
time_offset_s  seconds that the truth's clock is ahead, or "estimate"
rpe_seconds, rpe_frames, rpe_metres  steps of the relative errors
limits         {"file_bytes": 1e10}: what the files may ask for at most; the keys of --limits

Returns {name: figures}; names are "closed form", "optimised", ... Figures: position_rmse_m,
rotation_rmse_rad (ATE), rpe_time, rpe_frames, rpe_distance, velocity_rmse_mps,
rate_rmse_radps, nees, alignment, and others, as tagtwist_compare --json writes them.)");
}

}  // namespace tagtwist::internal::python
