# ROS 1 bags, where ROS' library and messages are installed (Debian: librosbag-storage-dev, libsensor-msgs-dev,
# libgeometry-msgs-dev, libnav-msgs-dev; headers of others come with them). No find_package: the packages' own
# scripts ask for more than there is.
option(TAGTWIST_ROSBAG "Read ROS 1 bags where rosbag_storage is installed" ON)
set(TAGTWIST_ROSBAG_LIBRARIES)
set(TAGTWIST_ROSBAG_INCLUDE_DIRS)
if(TAGTWIST_ROSBAG)
  set(missing)
  foreach(library rosbag_storage roscpp_serialization rostime cpp_common console_bridge class_loader
      ament_index_cpp rcpputils boost_filesystem)
    find_library(TAGTWIST_LIB_${library} ${library})
    mark_as_advanced(TAGTWIST_LIB_${library})
    list(APPEND TAGTWIST_ROSBAG_LIBRARIES ${TAGTWIST_LIB_${library}})
    if(NOT TAGTWIST_LIB_${library})
      list(APPEND missing ${library})
    endif()
  endforeach()
  # The last four keep their headers a folder deeper, rcutils with a time.h that must not hide the system's.
  foreach(header rosbag/bag.h sensor_msgs/Image.h geometry_msgs/PoseStamped.h nav_msgs/Odometry.h
      pluginlib/class_loader.hpp class_loader/class_loader.hpp ament_index_cpp/get_resource.hpp
      rcpputils/shared_library.hpp rcutils/types.h)
    string(REGEX REPLACE "/.*" "" package ${header})
    find_path(TAGTWIST_INCLUDE_${package} ${header} PATH_SUFFIXES ${package})
    mark_as_advanced(TAGTWIST_INCLUDE_${package})
    if(NOT TAGTWIST_INCLUDE_${package} STREQUAL /usr/include)  # is looked at anyway, and must not come sooner
      list(APPEND TAGTWIST_ROSBAG_INCLUDE_DIRS ${TAGTWIST_INCLUDE_${package}})
    endif()
    if(NOT TAGTWIST_INCLUDE_${package})
      list(APPEND missing ${header})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES TAGTWIST_ROSBAG_INCLUDE_DIRS)
  if(missing)
    message(STATUS "ROS bags are not read: no ${missing}")
    set(TAGTWIST_ROSBAG_LIBRARIES)
  endif()
endif()
