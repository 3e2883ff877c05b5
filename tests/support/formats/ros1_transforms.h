#pragma once
#include <geometry_msgs/TransformStamped.h>
#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <string>
#include <vector>

namespace tagtwist::internal {

/// tf2_msgs/TFMessage as ROS 1 writes it, without the package that defines it.
struct Ros1Transforms {
  std::vector<geometry_msgs::TransformStamped> transforms;
};

}  // namespace tagtwist::internal

namespace ros {
namespace message_traits {

template <>
struct MD5Sum<tagtwist::internal::Ros1Transforms> {
  static const char* value() { return "94810edda583a504dfda3829e70d7eec"; }
  static const char* value(const tagtwist::internal::Ros1Transforms& /*message*/) {
    return value();
  }
};
template <>
struct DataType<tagtwist::internal::Ros1Transforms> {
  static const char* value() { return "tf2_msgs/TFMessage"; }
  static const char* value(const tagtwist::internal::Ros1Transforms& /*message*/) {
    return value();
  }
};
template <>
struct Definition<tagtwist::internal::Ros1Transforms> {
  static const char* value() { return "geometry_msgs/TransformStamped[] transforms\n"; }
  static const char* value(const tagtwist::internal::Ros1Transforms& /*message*/) {
    return value();
  }
};

}  // namespace message_traits
namespace serialization {

template <>
struct Serializer<tagtwist::internal::Ros1Transforms> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message message) {  // the name that ROS calls
    stream.next(message.transforms);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
