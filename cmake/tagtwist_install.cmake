# `cmake --install`: programs, libraries with their headers, and the package that find_package(tagtwist)
# finds: tagtwist::estimator (Eigen and Ceres alone), tagtwist::online (images in, states out) and the others. `cpack`: the same as
# Debian packages, tagtwist (programs), tagtwist-dev and python3-tagtwist.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(libraries base types geometry frontend simulation io residuals estimator online jobs report)
foreach(library ${libraries})
  set_target_properties(tagtwist_${library} PROPERTIES EXPORT_NAME ${library})
  install(TARGETS tagtwist_${library} EXPORT tagtwist_targets
    DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
endforeach()

# Public headers, rewritten to include each other as <tagtwist/...>: nothing of a user's is ever found in their place.
include(cmake/public_headers.cmake)
set(public_dir ${PROJECT_BINARY_DIR}/public)
set(public_headers)
foreach(header ${TAGTWIST_PUBLIC_HEADERS})
  set(copy ${public_dir}/tagtwist/${header})
  add_custom_command(OUTPUT ${copy}
    COMMAND ${CMAKE_COMMAND} -DFILE=${PROJECT_SOURCE_DIR}/${header} -DCOPY=${copy}
            -P ${PROJECT_SOURCE_DIR}/cmake/public_header.cmake
    DEPENDS ${header} cmake/public_header.cmake VERBATIM)
  list(APPEND public_headers ${copy})
endforeach()
add_custom_target(tagtwist_copy_headers ALL DEPENDS ${public_headers})
add_library(tagtwist_headers INTERFACE)
add_dependencies(tagtwist_headers tagtwist_copy_headers)
target_sources(tagtwist_headers INTERFACE FILE_SET HEADERS BASE_DIRS ${public_dir} FILES ${public_headers})
set_target_properties(tagtwist_headers PROPERTIES EXPORT_NAME headers)
install(TARGETS tagtwist_headers EXPORT tagtwist_targets
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)

install(TARGETS tagtwist_camera tagtwist_compare tagtwist_estimate tagtwist_map tagtwist_simulate
  DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
install(DIRECTORY ${PROJECT_BINARY_DIR}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR}
  COMPONENT programs FILES_MATCHING PATTERN "*.1.gz")
install(PROGRAMS apps/fleet/tagtwist_fleet DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
install(DIRECTORY apps/fleet/workflow/ DESTINATION ${CMAKE_INSTALL_DATADIR}/tagtwist/fleet
  COMPONENT programs USE_SOURCE_PERMISSIONS PATTERN "__pycache__" EXCLUDE)
install(FILES configs/course.yaml DESTINATION ${CMAKE_INSTALL_DATADIR}/tagtwist
  COMPONENT programs)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tagtwist)
install(EXPORT tagtwist_targets NAMESPACE tagtwist:: DESTINATION ${package_dir}
  COMPONENT dev)
configure_package_config_file(cmake/tagtwist-config.cmake.in
  ${PROJECT_BINARY_DIR}/tagtwist-config.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tagtwist-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tagtwist-config.cmake
  ${PROJECT_BINARY_DIR}/tagtwist-config-version.cmake DESTINATION ${package_dir} COMPONENT dev)

if(TAGTWIST_BUILD_PYTHON)
  # Where the system's Python looks: packages under /usr, of all else the folder of its version.
  install(CODE "
    set(version python${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR})
    if(CMAKE_INSTALL_PREFIX MATCHES \"/usr/?$\")
      set(version python3)
    endif()
    file(INSTALL \"$<TARGET_FILE:tagtwist_python>\" \"${PROJECT_SOURCE_DIR}/apps/python/tagtwist.pyi\"
      DESTINATION \"\${CMAKE_INSTALL_PREFIX}/lib/\${version}/dist-packages\")"
    COMPONENT python)
endif()

set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # tests and benchmarks need not be built for it
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the tagtwist developers <tagtwist@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Motion capture from a printed sheet of AprilTags")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL programs dev)
if(TAGTWIST_BUILD_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME tagtwist)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "python3-yaml")  # tagtwist_fleet, and its engine
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SUGGESTS "snakemake")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME tagtwist-dev)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-tagtwist)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
math(EXPR next_python "${Python3_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
# The libraries are static: who links them needs all that they stand on.
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "libeigen3-dev, libceres-dev, libopencv-dev, libpng-dev, libapriltag-dev, libmatio-dev, libhdf5-dev, zlib1g-dev, libtinyxml2-dev, libyaml-cpp-dev, nlohmann-json3-dev, libavformat-dev, libavcodec-dev, libavutil-dev, libsqlite3-dev, libfastcdr-dev, liblz4-dev, libzstd-dev, nettle-dev, pkg-config")
if(TAGTWIST_ROSBAG_LIBRARIES)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", librosbag-storage-dev")
endif()
include(CPack)
