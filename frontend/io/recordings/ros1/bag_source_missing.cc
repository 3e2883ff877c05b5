// In place of bag_source.cc and bag_messages.cc where ROS' library is not installed.
#include "frontend/io/recordings/data_source_kinds.h"

namespace tagtwist::internal {

Result<std::unique_ptr<DataSource>> OpenBagSource(const std::string& path,
                                                  const DataSourceOptions&) {
  return Error{path + ": a ROS bag, and this build reads none (it needs librosbag-storage-dev)"};
}

}  // namespace tagtwist::internal
