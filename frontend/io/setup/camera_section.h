#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/io/setup/yaml_reader.h"
#include "frontend/types/camera.h"

namespace tagtwist::internal {

/// A lens model by the names that calibration files give it: radtan, plumb_bob and
/// rational_polynomial; equidistant and fisheye; ds, eucm, omni, fov; none. Any other is refused.
struct NamedLens {
  LensModel model = LensModel::kRadialTangential;
  bool has_coefficients = true;
};
Result<NamedLens> ReadLensName(const YamlValue& node);

/// Gives the camera a lens. radtan: 4, 5 or 8 coefficients in OpenCV's order; the others as many as
/// they have (LensCoefficients); more of them must be zero. `node`: where they stand in the file.
Status SetLens(const YamlValue& node, const NamedLens& lens, std::vector<double> coefficients,
               Camera* camera);

/// The keys of the section `camera` (docs/formats.md) from a section that may have others, too.
void ReadCameraKeys(YamlSection* section, Camera* camera);
/// Reads what is known of both focal lengths: `focal_sigma`, a relative standard deviation.
void ReadFocalSigma(YamlSection* section, std::optional<double>* focal_sigma);
/// Reads the shutter of the camera: `line_time_s`, [s] from row to row.
void ReadLineTime(YamlSection* section, double* line_time_s);

}  // namespace tagtwist::internal
