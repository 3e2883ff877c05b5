# Packs the build, installs it into an empty prefix, and builds and runs tests/installed/ against it, outside the
# tree: -DBUILD=<build folder> -DEXAMPLE=<source folder> -DWORK=<folder to work in> and where the Python
# module was built -DPYTHON=<interpreter> -DPYTHON_VERSION=<python3.11>.
file(REMOVE_RECURSE ${WORK})
file(COPY ${EXAMPLE}/ DESTINATION ${WORK}/source)
if(PYTHON)
  set(path PYTHONPATH=${WORK}/prefix/lib/${PYTHON_VERSION}/dist-packages)
  set(python_steps
    "${CMAKE_COMMAND}|-E|env|${path}|${PYTHON}|${WORK}/source/example.py|${WORK}/flight")
endif()
set(course ${WORK}/prefix/share/tagtwist/course.yaml)
function(run step)
  string(REPLACE "|" ";" command "${step}")
  execute_process(COMMAND ${command} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${step}: ${status}\n${out}")
  endif()
  message(STATUS "${out}")
endfunction()
set(configure "-DCMAKE_PREFIX_PATH=${WORK}/prefix|-DCMAKE_BUILD_TYPE=Release|-GUnix Makefiles")
run("${CMAKE_COMMAND}|-E|chdir|${BUILD}|cpack|-B|${WORK}/packages")
run("${CMAKE_COMMAND}|--install|${BUILD}|--prefix|${WORK}/prefix")
file(READ ${course} text)
string(REPLACE "line_time_s: 0 " "line_time_s: 60e-6 " rolling "${text}")
file(WRITE ${WORK}/rolling.yaml "${rolling}")
set(simulate "${WORK}/prefix/bin/tagtwist_simulate|--output")
foreach(step
    "${CMAKE_COMMAND}|-S|${WORK}/source|-B|${WORK}/build|${configure}"
    "${CMAKE_COMMAND}|--build|${WORK}/build"
    "${CMAKE_COMMAND}|-S|${WORK}/source/estimator_only|-B|${WORK}/build_estimator_only|${configure}"
    "${CMAKE_COMMAND}|--build|${WORK}/build_estimator_only"
    "${WORK}/build_estimator_only/estimator_only"
    "${simulate}|${WORK}/flight|--trajectory|hover|--duration|1"
    "${simulate}|${WORK}/rolling|--trajectory|figure8|--duration|4|--images=false|--line_time_s|60e-6"
    "${WORK}/build/batch|${course}|${WORK}/flight"
    "${WORK}/build/online|${course}|${WORK}/flight"
    "${WORK}/build/rolling_shutter|${WORK}/rolling.yaml|${WORK}/rolling"
    ${python_steps}
    "${WORK}/prefix/bin/tagtwist_estimate|--version"
    "${WORK}/prefix/bin/tagtwist_fleet|--recordings|${WORK}|--output|${WORK}/fleet|--dry_run")
  run("${step}")
endforeach()

# The configuration alone makes the difference: without it the same program is far off.
execute_process(COMMAND ${WORK}/build/rolling_shutter ${course} ${WORK}/rolling RESULT_VARIABLE status OUTPUT_VARIABLE out)
if(status EQUAL 0)
  message(FATAL_ERROR "a rolling shutter that no configuration tells of went unnoticed: ${out}")
endif()

file(READ ${WORK}/build_estimator_only/CMakeFiles/estimator_only.dir/link.txt link_line)
if(link_line MATCHES "opencv" OR NOT link_line MATCHES "ceres")
  message(FATAL_ERROR "tagtwist::estimator is to link Ceres and no OpenCV: ${link_line}")
endif()
foreach(program compare estimate fleet map simulate)
  if(NOT EXISTS ${WORK}/prefix/share/man/man1/tagtwist_${program}.1.gz)
    message(FATAL_ERROR "tagtwist_${program} has no man page")
  endif()
endforeach()
