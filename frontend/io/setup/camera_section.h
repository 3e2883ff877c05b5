#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "frontend/io/setup/yaml_reader.h"
#include "frontend/types/camera.h"
#include "frontend/types/rig.h"

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
/// Reads the shutter of the camera: `line_time_s`, [s] from row to row.
void ReadLineTime(YamlSection* section, double* line_time_s);

/// Entries of a lens in RigCamera::covariance; the mount's six follow.
Eigen::Index LensEntries(const Camera& camera);
/// Reads what a section `camera`, whose lens is read, says of its errors (docs/formats.md) into the
/// lens's part of a RigCamera::covariance; that stays as it is where nothing is said.
void ReadLensSigmas(YamlSection* section, const Camera& camera, Eigen::MatrixXd* covariance);
/// The same of a section `cam_from_body` or `cam_from_world` into the mount's part. `own_lens`: it
/// stands beside the lens that its correlations are with; else those do not count.
void ReadMountSigmas(YamlSection* section, bool own_lens, RigCamera* camera);
/// These keys as they are read, each line behind an indent; empty where nothing is known.
std::string LensSigmaLines(const RigCamera& camera, const std::string& indent);
std::string MountSigmaLines(const RigCamera& camera, const std::string& indent);

}  // namespace tagtwist::internal
