#include "frontend/io/tables/detections_csv.h"

#include "frontend/base/number_text.h"

namespace tagtwist::internal {

std::vector<std::string> TagCovarianceNames() {
  std::vector<std::string> out;
  for (int row = 1; row <= 8; ++row) {
    for (int column = row; column <= 8; ++column) {
      out.push_back("c" + std::to_string(row) + std::to_string(column));
    }
  }
  return out;
}

std::string MeasuredTagsHeader() {
  std::string out = DetectionsCsvHeader(TimeUnit::kSeconds);
  out.pop_back();
  for (const std::string& name : TagCovarianceNames()) out += "," + name;
  return out + ",doubled\n";
}

std::string FormatMeasuredTags(int64_t t_ns, const std::vector<TagDetection>& tags,
                               const std::vector<int>& doubled_ids) {
  std::string out;
  for (const TagDetection& tag : tags) {
    out += FormatDetections(t_ns, {tag}, TimeUnit::kSeconds);
    out.pop_back();
    for (int i = 0; i < 8; ++i) {
      for (int j = i; j < 8; ++j) {
        out += "," + (tag.covariance ? FormatNumber((*tag.covariance)(i, j)) : std::string());
      }
    }
    out += ",\n";
  }
  constexpr int kCornerColumns = 8, kCovarianceColumns = 36;
  for (const int id : doubled_ids) {
    out += FormatStamp(t_ns, TimeUnit::kSeconds) + "," + std::to_string(id) +
           std::string(kCornerColumns + kCovarianceColumns, ',') + ",1\n";
  }
  return out;
}

std::string DetectionsCsvHeader(TimeUnit unit) {
  return unit == TimeUnit::kSeconds
             ? "t,id,u1,v1,u2,v2,u3,v3,u4,v4\n"
             : "#timestamp [ns],id,u1 [px],v1 [px],u2 [px],v2 [px],u3 [px],v3 [px],u4 [px],v4 "
               "[px]\n";
}

std::string FormatDetections(int64_t t_ns, const std::vector<TagDetection>& tags, TimeUnit unit) {
  std::string out;
  for (const TagDetection& tag : tags) {
    out += FormatStamp(t_ns, unit) + "," + std::to_string(tag.id);
    for (const Eigen::Vector2d& corner : tag.corners) {
      out += "," + FormatNumber(corner.x()) + "," + FormatNumber(corner.y());
    }
    out += "\n";
  }
  return out;
}

}  // namespace tagtwist::internal
