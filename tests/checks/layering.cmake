# Which room of the code may use which, read from one table; run with -DROOT=<source tree>. Debian keeps Ceres,
# glog and gflags in /usr/include, so link lists alone do not stop an include. Every fault is told.

cmake_minimum_required(VERSION 3.22)
get_filename_component(ROOT "${ROOT}" ABSOLUTE)

# room | rooms that it may use, and all that those may use | libraries beside the standard one and Eigen
# A file belongs to the room with the longest name that leads to it.
set(table
  "frontend/base        |                                           | nettle"
  "frontend/types       | frontend/base                             | apriltag"
  "frontend/geometry    | frontend/types                            |"
  "frontend/pattern     | frontend/geometry                         | opencv2"
  "frontend/tags        | frontend/pattern                          | opencv2 apriltag"
  "frontend/flow        | frontend/geometry                         | opencv2"
  "frontend             | frontend/tags frontend/flow               | opencv2"
  "frontend/simulation  | frontend/types                            | opencv2"
  "frontend/io          | frontend/types                            | opencv2 matio.h hdf5.h zlib.h png.h yaml-cpp tinyxml2.h ros ffmpeg sqlite3.h lz4frame.h zstd.h fastcdr"
  "residuals            | frontend/types                            | ceres"
  "estimator/linear     | residuals frontend/geometry               | ceres"
  "estimator/graph      | estimator/linear                          | ceres"
  "estimator/rig        | estimator/graph                           | ceres"
  "estimator/result     | estimator/rig                             | ceres"
  "estimator/motion     | estimator/rig                             | ceres"
  "estimator/start      | estimator/rig                             | ceres"
  "estimator/solve      | estimator/graph estimator/result          | ceres"
  "estimator/systematic | estimator/result                          | ceres"
  "estimator/imu        | estimator/solve                           | ceres"
  "estimator/batch      | estimator/imu estimator/start estimator/systematic estimator/motion | ceres"
  "estimator/window     | estimator/imu estimator/start estimator/systematic estimator/motion | ceres"
  "estimator/calibration| estimator/start                           | ceres"
  "estimator/evaluation | estimator/calibration estimator/result    | ceres"
  "estimator/online     | estimator/batch estimator/window estimator/evaluation frontend frontend/io | opencv2"
  "estimator/live       | estimator/online                          | opencv2 threads"
  "estimator/jobs       | estimator/live                            | opencv2 threads iostream"
  "estimator/publish    | estimator/jobs                            | opencv2 nlohmann threads boost"
  "estimator/report     | estimator/batch estimator/window estimator/evaluation frontend/io | nlohmann"
  "estimator/fleet      | estimator/report                          | nlohmann"
  "apps                 | estimator/publish estimator/fleet frontend/simulation | opencv2 gflags glog threads iostream cairo"
  "apps/python          | apps                                      | opencv2 glog pybind11 threads"
)

# What a library's headers look like behind "#include <".
set(headers_opencv2 "opencv2/")
set(headers_ros "(rosbag|ros|sensor_msgs|geometry_msgs|nav_msgs|std_msgs|tf2_msgs|console_bridge)/")
set(headers_ffmpeg "libav[a-z]+/")
set(headers_threads "(chrono|ctime|thread|future|mutex|condition_variable)>")
set(headers_iostream "iostream>")
set(headers_system "[a-z_0-9]+>|(fcntl|unistd|signal|stdlib|dirent)[.]h>|(sys|linux)/|Eigen/")
set(one_file_each "yaml-cpp:frontend/io/setup/yaml_" "tinyxml2[.]h:frontend/io/setup/opencv_xml[.]")

function(fault text)
  message(SEND_ERROR "${text}")
endfunction()

# The table, as lists by room: rooms_<room> with all that they lead to, libraries_<room>.
set(rooms)
foreach(line ${table})
  string(REPLACE "|" ";" cells "${line} ")
  list(GET cells 0 room)
  list(GET cells 1 uses)
  list(GET cells 2 libraries)
  string(STRIP "${room}" room)
  string(REGEX MATCHALL "[^ ]+" rooms_${room} "${uses}")
  string(REGEX MATCHALL "[^ ]+" libraries_${room} "${libraries}")
  foreach(used ${rooms_${room}})  # rooms before it in the table: their own lists are whole
    list(APPEND rooms_${room} ${rooms_${used}})
  endforeach()
  list(APPEND rooms_${room} ${room})
  list(REMOVE_DUPLICATES rooms_${room})
  list(APPEND rooms ${room})
endforeach()

function(room_of path result)
  set(best)
  set(length 0)
  foreach(room ${rooms})
    string(LENGTH ${room} n)
    if(path MATCHES "^${room}/" AND n GREATER length)
      set(best ${room})
      set(length ${n})
    endif()
  endforeach()
  # The front of the frontend has files and no rooms but those of the table.
  if(best MATCHES "^(frontend|residuals)$" AND path MATCHES "^[a-z]+/[^/]+/")
    set(best)
  endif()
  set(${result} "${best}" PARENT_SCOPE)
endfunction()

# A header of a library: the first library of the table that it is of must be among the room's.
function(check_library file room include)
  foreach(library threads iostream)
    if(include MATCHES "^${headers_${library}}" AND NOT library IN_LIST libraries_${room})
      fault("${file}: room ${room} may not have <${include}")
      return()
    endif()
  endforeach()
  if(include MATCHES "^(${headers_system})")
    return()
  endif()
  foreach(library ${libraries_${room}})
    set(pattern "${library}[/>]")
    if(DEFINED headers_${library})
      set(pattern "${headers_${library}}")
    endif()
    if(include MATCHES "^${pattern}")
      foreach(rule ${one_file_each})
        string(REPLACE ":" ";" rule "${rule}")
        list(GET rule 0 header)
        list(GET rule 1 files)
        if(include MATCHES "^${header}" AND NOT file MATCHES "^${files}")
          fault("${file}: only ${files} may include <${include}")
        endif()
      endforeach()
      return()
    endif()
  endforeach()
  fault("${file}: room ${room} may not have <${include}")
endfunction()

# A unit is a header with its source; edges_<unit> are the units of the same room that it includes.
set(units)
file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/frontend/*.h ${ROOT}/frontend/*.cc ${ROOT}/residuals/*.h
  ${ROOT}/residuals/*.cc ${ROOT}/estimator/*.h ${ROOT}/estimator/*.cc ${ROOT}/apps/*.h ${ROOT}/apps/*.cc)
foreach(file ${files})
  room_of(${file} room)
  if(NOT room)
    fault("${file}: its folder is no room of the table in tests/checks/layering.cmake")
    continue()
  endif()
  string(REGEX REPLACE "[.](h|cc)$" "" unit ${file})
  list(APPEND units ${unit})
  file(STRINGS ${ROOT}/${file} includes REGEX "^#include ")
  foreach(line ${includes})
    string(REGEX REPLACE "^#include (<|\")" "" include "${line}")
    if(line MATCHES "^#include <")
      check_library(${file} ${room} "${include}")
      continue()
    endif()
    string(REGEX REPLACE "[.]h\".*" "" other "${include}")
    room_of("${other}" other_room)
    if(NOT other_room IN_LIST rooms_${room})
      fault("${file}: room ${room} may not use ${other}.h")
    elseif(other_room STREQUAL room AND NOT other STREQUAL unit)
      list(APPEND edges_${unit} ${other})
    endif()
  endforeach()
endforeach()
list(REMOVE_DUPLICATES units)

# Units that use none that is left are taken away, until none is; what remains goes round in a circle.
set(changed TRUE)
while(changed)
  set(changed FALSE)
  set(left)
  foreach(unit ${units})
    set(open FALSE)
    foreach(other ${edges_${unit}})
      if(other IN_LIST units)
        set(open TRUE)
        break()
      endif()
    endforeach()
    if(open)
      list(APPEND left ${unit})
    else()
      set(changed TRUE)
    endif()
  endforeach()
  set(units ${left})
endwhile()
foreach(unit ${units})
  fault("${unit}: part of, or leads into, a circle of includes within its room")
endforeach()
