#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <type_traits>

#include "apps/python/python_types.h"
#include "estimator/online/config.h"
#include "frontend/base/named_enum.h"
#include "frontend/io/setup/camera_file.h"
#include "frontend/io/setup/tag_map_file.h"
#include "frontend/types/lens/lens.h"

namespace tagtwist::internal::python {
namespace {

namespace fs = std::filesystem;
using OptionalPath = std::optional<fs::path>;

std::string TextOf(const OptionalPath& path) { return path ? path->string() : ""; }

TagMapFile MapFile(const OptionalPath& path, std::optional<double> tag_size_m,
                   const std::string& family) {
  if (tag_size_m && !(*tag_size_m > 0)) {
    throw Refusal("tag_size_m: expected > 0, got " + std::to_string(*tag_size_m));
  }
  return {TextOf(path), tag_size_m, family};
}

Config Load(const OptionalPath& path, const OptionalPath& camera_file, const std::string& camera,
            const OptionalPath& map, std::optional<double> tag_size_m,
            const std::string& tag_family, const std::vector<int>& movable_tags,
            const LimitValues& limits) {
  return TakeOrRaise(LoadConfig(ConfigFiles{TextOf(path), TextOf(camera_file), camera,
                                            MapFile(map, tag_size_m, tag_family), movable_tags,
                                            ToLimits(limits)}));
}

// An option as Python has it: an enum is its name.
template <typename Field>
py::object ToPython(const Field& field) {
  if constexpr (std::is_enum_v<Field>) {
    return py::str(NameOf(field));
  } else {
    return py::cast(field);
  }
}

template <typename Field>
void FromPython(const std::string& key, const py::object& value, Field* field) {
  if constexpr (std::is_enum_v<Field>) {
    const auto name = value.cast<std::string>();
    const auto named = ValueOf<Field>(name);
    if (!named) throw Refusal(key + ": expected " + NamesOf<Field>() + ", got '" + name + "'");
    *field = *named;
  } else {
    *field = value.cast<Field>();
  }
}

// Calls visit(name, options) for each struct of options, by the name of its section.
template <typename Visitor>
void VisitSections(Config& config, Visitor&& visit) {
  visit("detector", config.front_end.detector);
  visit("klt", config.front_end.klt);
  visit("closed_form", config.front_end.closed_form);
  visit("estimator", config.estimator);
  visit("calibration", config.calibration);
}

py::dict OptionsOf(Config& config) {
  py::dict out;
  VisitSections(config, [&](const char* section, auto& options) {
    py::dict fields;
    std::decay_t<decltype(options)>::VisitFields(
        options, [&](const char* key, auto& value) { fields[key] = ToPython(value); });
    out[section] = fields;
  });
  return out;
}

template <typename Options>
bool SetField(const std::string& key, const py::object& value, Options* options) {
  bool is_known = false;
  const auto set = [&](const char* name, auto& field) {
    if (key != name) return;
    is_known = true;
    try {
      FromPython(key, value, &field);
    } catch (const py::cast_error&) {
      throw Refusal(key + ": expected a value like " + std::string(py::repr(ToPython(field))) +
                    ", got " + std::string(py::repr(value)));
    }
  };
  Options::VisitFields(*options, set);
  return is_known;
}

// Sets "section.key"; the configuration stays as it is where the value is refused.
void SetOption(Config* config, const std::string& name, const py::object& value) {
  const size_t dot = name.find('.');
  const std::string wanted = name.substr(0, dot);
  const std::string key = dot == std::string::npos ? "" : name.substr(dot + 1);
  Config changed = *config;
  bool is_known = false;
  VisitSections(changed, [&](const char* section, auto& options) {
    if (wanted != section || !SetField(key, value, &options)) return;
    is_known = true;
    if (const auto problem = options.Problem()) throw Refusal(wanted + "." + *problem);
  });
  if (!is_known) throw Refusal(name + ": no such option; Config.options has them all");
  *config = std::move(changed);
}

Array MatrixOf(const Pose& pose) {
  Eigen::Matrix4d out = Eigen::Matrix4d::Identity();
  out.topLeftCorner<3, 3>() = pose.rotation().toRotationMatrix();
  out.topRightCorner<3, 1>() = pose.translation();
  return FromMatrix(out);
}

Pose PoseOfMatrix(const py::object& object) {
  const Array array = ToArray(object, "cam_from_body", {4, 4});
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(array.data());
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const bool is_rigid =
      (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() < 1e-6 &&
      rotation.determinant() > 0 && matrix.row(3) == Eigen::RowVector4d(0, 0, 0, 1) &&
      matrix.allFinite();
  if (!is_rigid) throw Refusal("cam_from_body: expected a rigid transform, [R t; 0 0 0 1]");
  return MakePose(Eigen::Quaterniond(rotation), matrix.topRightCorner<3, 1>());
}

Array MapCornersOf(const TagMap& map) {
  Array out({static_cast<py::ssize_t>(map.tags().size()), py::ssize_t{4}, py::ssize_t{3}});
  double* to = out.mutable_data();
  for (const Tag& tag : map.tags()) {
    for (const Eigen::Vector3d& corner : map.CornersInWorld(tag.id)) {
      for (const double value : corner) *to++ = value;
    }
  }
  return out;
}

void BindMapAndCamera(py::module_& module) {
  py::class_<Camera>(module, "Camera", "A pinhole camera with a lens (read_camera).")
      .def_readonly("width", &Camera::width, "[px]")
      .def_readonly("height", &Camera::height, "[px]")
      .def_property_readonly(
          "matrix",
          [](const Camera& c) {
            Eigen::Matrix3d k;
            k << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1;
            return FromMatrix(k);
          },
          "(3, 3) [px]; the centre of the top-left pixel is (0, 0)")
      .def_property_readonly(
          "lens", [](const Camera& c) { return LensName(c.lens); },
          "\"radtan\", \"equidistant\", \"ds\", \"eucm\", \"omni\" or \"fov\"")
      .def_property_readonly(
          "distortion",
          [](const Camera& c) {
            const auto& coefficients = LensCoefficients(c.lens);
            Eigen::VectorXd out(static_cast<Eigen::Index>(coefficients.size()));
            for (size_t i = 0; i < coefficients.size(); ++i) {
              out(static_cast<Eigen::Index>(i)) = c.*coefficients[i].value;
            }
            return FromMatrix(out);
          },
          "k1 k2 p1 p2 k3 k4 k5 k6 of radtan, k1..k4 of equidistant, as OpenCV orders them; xi "
          "alpha "
          "of ds, alpha beta of eucm, xi k1 k2 p1 p2 of omni, w of fov");
  py::class_<TagMap>(module, "TagMap", "Where the tags are (read_map).")
      .def_property_readonly("family", &TagMap::family, "\"tag36h11\"")
      .def_property_readonly(
          "ids",
          [](const TagMap& map) {
            std::vector<int> out;
            for (const Tag& tag : map.tags()) out.push_back(tag.id);
            return out;
          },
          "ids of the M tags")
      .def_property_readonly("corners", &MapCornersOf,
                             "(M, 4, 3) in W [m]: bottom-left, bottom-right, top-right, top-left "
                             "of each tag as printed")
      .def("__len__", [](const TagMap& map) { return map.tags().size(); });
}

}  // namespace

void BindConfig(py::module_& module) {
  BindMapAndCamera(module);
  py::class_<Config>(module, "Config",
                     "Camera, mount, tag map and options of an estimate; from load_config().")
      .def_property(
          "camera", [](const Config& config) { return config.set_up.rig.front().camera; },
          [](Config& config, const Camera& camera) {
            config.set_up.rig.front().camera = camera;
            config.set_up.rig.front().covariance.resize(0, 0);  // of another lens
          },
          "tagtwist.Camera")
      .def_property(
          "map", [](const Config& config) { return config.set_up.map; },
          [](Config& config, const TagMap& map) { config.set_up.map = map; }, "tagtwist.TagMap")
      .def_property(
          "cam_from_body",
          [](const Config& config) { return MatrixOf(config.set_up.rig.front().cam_from_body); },
          [](Config& config, const py::object& matrix) {
            config.set_up.rig.front().cam_from_body = PoseOfMatrix(matrix);
          },
          "(4, 4): x_cam = R x_body + t")
      .def_property_readonly("options", &OptionsOf,
                             "{section: {key: value}}, a copy; the keys of configs/course.yaml")
      .def("set", &SetOption, py::arg("name"), py::arg("value"),
           "Sets an option: config.set(\"estimator.window_frames\", 20).");
  module.def("load_config", &Load, py::arg("path") = py::none(), py::kw_only(),
             py::arg("camera_file") = py::none(), py::arg("camera") = "",
             py::arg("map") = py::none(), py::arg("tag_size_m") = py::none(),
             py::arg("tag_family") = "", py::arg("movable_tags") = std::vector<int>(),
             py::arg("limits") = py::none(),
             R"(Config from a YAML file; without one, the defaults of configs/course.yaml.

camera_file  calibration instead of the file's camera: Kalibr, OpenCV, ROS
camera       which of its cameras, "cam1"
map          tag map instead of the file's: Kalibr, WPILib, TagSLAM
tag_size_m   side of a black square [m], where the map does not say it
tag_family   where the map does not say it
movable_tags ids of tags that may be anywhere: passed over
limits       {"frame_pixels": 4e8}: what these files, and the recordings that are read with the
             Config, may ask for at most; the keys of --limits)");
  module.def(
      "read_camera",
      [](const fs::path& path, const std::string& name, const LimitValues& limits) {
        return TakeOrRaise(ReadCameraFile(path.string(), name, ToLimits(limits))).camera;
      },
      py::arg("path"), py::arg("name") = "", py::kw_only(), py::arg("limits") = py::none(),
      "Camera from a calibration: Kalibr, OpenCV, ROS, or a configuration.");
  module.def(
      "read_map",
      [](const fs::path& path, std::optional<double> tag_size_m, const std::string& family,
         const LimitValues& limits) {
        return TakeOrRaise(ReadTagMapFile(MapFile(path, tag_size_m, family), ToLimits(limits)));
      },
      py::arg("path"), py::kw_only(), py::arg("tag_size_m") = py::none(),
      py::arg("tag_family") = "", py::arg("limits") = py::none(),
      "TagMap from a file: Kalibr aprilgrid, WPILib, TagSLAM, or a configuration.");
}

}  // namespace tagtwist::internal::python
