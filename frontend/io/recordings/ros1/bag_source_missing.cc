// In place of bag_source.cc and bag_messages.cc where ROS' library is not installed.
#include "frontend/io/recordings/camera_info.h"
#include "frontend/io/recordings/data_source_kinds.h"

namespace tagtwist::internal {
namespace {

Error NotRead(const std::string& path) {
  return Error{path + ": a ROS bag, and this build reads none (it needs librosbag-storage-dev)"};
}

}  // namespace

Result<RosCameraInfo> ReadRos1CameraInfo(const std::string& path, const std::string&,
                                         const Limits&) {
  return NotRead(path);
}

Result<std::unique_ptr<DataSource>> OpenBagSource(const std::string& path,
                                                  const DataSourceOptions&) {
  return NotRead(path);
}

}  // namespace tagtwist::internal
