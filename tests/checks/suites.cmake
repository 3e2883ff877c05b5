# Each case of a program is in one of ctest's tests and in one alone, with the label that its name asks for. Run with
# -DROOT=<source tree> -DWORK=<folder>.
cmake_minimum_required(VERSION 3.23)
file(MAKE_DIRECTORY ${WORK})
file(WRITE ${WORK}/program "#!/bin/sh
cat <<'END'
A.
  X
  SlowY
  RealDataZ
  DISABLED_W
SlowB.
  V
All/RealDataC.
  U/0  # GetParam() = \"a;[b]\"
  U/1  # GetParam() = 2
Typed/0.  # TypeParam = int
  T
END
")
file(CHMOD ${WORK}/program PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
execute_process(COMMAND ${CMAKE_COMMAND} -DPROGRAM=${WORK}/program -DROOM=room -DFILE=${WORK}/suites.cmake
  -DLONGEST=A -DENVIRONMENT=A=B -P ${ROOT}/cmake/tagtwist_suites.cmake COMMAND_ERROR_IS_FATAL ANY)
set(found "")
function(add_test name program filter)
  string(APPEND found "${name} ${filter}")
  set(found "${found}" PARENT_SCOPE)
endfunction()
function(set_tests_properties name)
  string(REGEX MATCH "LABELS;.*$" label "${ARGN}")
  string(REPLACE ";" " " label "${label}")
  string(APPEND found " ${label}\n")
  set(found "${found}" PARENT_SCOPE)
endfunction()
include(${WORK}/suites.cmake)
set(expected "room/A --gtest_filter=A.*-*RealData*:*Slow* \n\
room/A.Slow --gtest_filter=A.*Slow*-*RealData* LABELS slow\n\
room/A.RealData --gtest_filter=A.*RealData* LABELS real_data\n\
room/SlowB --gtest_filter=SlowB.*-*RealData* LABELS slow\n\
room/All/RealDataC --gtest_filter=All/RealDataC.* LABELS real_data\n\
room/Typed/0 --gtest_filter=Typed/0.*-*RealData*:*Slow* \n")
if(NOT found STREQUAL expected)
  message(FATAL_ERROR "expected\n${expected}got\n${found}")
endif()
