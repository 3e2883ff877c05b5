#pragma once
#include <string>
#include <string_view>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Checks the records of a ROS 1 bag, format 2.0 (wiki.ros.org/Bags/Format/2.0), before ROS' own
/// library reads it, which trusts their lengths and places: every header's fields fill it, records
/// lie within the file, chunks and indices are where others say, chunks do not become absurdly
/// large, and images in chunks that are not compressed have the bytes that they announce. Looks at
/// headers alone, not at what messages hold.
/// "x.bag: a damaged bag: the record at byte 13 does not add up".
Status CheckBagRecords(const std::string& path, const Limits& limits = {});

/// Whether the bytes of a message's array, its last member, are there: ROS makes room for as many
/// as it announces before it looks. Of a sensor_msgs/Image, or a CompressedImage.
bool IsSoundImage(std::string_view message, bool compressed);

}  // namespace tagtwist::internal
