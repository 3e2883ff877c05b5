# Packs the build, installs it into an empty prefix, and builds and runs tests/installed/ against it, outside the
# tree: -DBUILD=<build folder> -DEXAMPLE=<source folder> -DWORK=<folder to work in> and where the Python
# module was built -DPYTHON=<interpreter> -DPYTHON_VERSION=<python3.11>.
file(REMOVE_RECURSE ${WORK})
file(COPY ${EXAMPLE}/ DESTINATION ${WORK}/source)
if(PYTHON)
  set(path PYTHONPATH=${WORK}/prefix/lib/${PYTHON_VERSION}/dist-packages)
  set(python_steps
    "${WORK}/prefix/bin/tagtwist_simulate|--output|${WORK}/flight|--trajectory|hover|--duration|1"
    "${CMAKE_COMMAND}|-E|env|${path}|${PYTHON}|${WORK}/source/example.py|${WORK}/flight")
endif()
foreach(step
    "${CMAKE_COMMAND}|-E|chdir|${BUILD}|cpack|-B|${WORK}/packages"
    "${CMAKE_COMMAND}|--install|${BUILD}|--prefix|${WORK}/prefix"
    "${CMAKE_COMMAND}|-S|${WORK}/source|-B|${WORK}/build|-DCMAKE_PREFIX_PATH=${WORK}/prefix|-DCMAKE_BUILD_TYPE=Release"
    "${CMAKE_COMMAND}|--build|${WORK}/build"
    "${WORK}/build/example"
    ${python_steps}
    "${WORK}/prefix/bin/tagtwist_estimate|--version")
  string(REPLACE "|" ";" command "${step}")
  execute_process(COMMAND ${command} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${step}: ${status}\n${out}")
  endif()
endforeach()
foreach(program compare estimate map simulate)
  if(NOT EXISTS ${WORK}/prefix/share/man/man1/tagtwist_${program}.1.gz)
    message(FATAL_ERROR "tagtwist_${program} has no man page")
  endif()
endforeach()
message(STATUS "${out}")
