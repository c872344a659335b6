# SPDX-License-Identifier: MIT
# `find_package(turnscale)` for others: the modules as turnscale::<module>, the headers, and what they need.
include(CMakePackageConfigHelpers)

get_property(modules GLOBAL PROPERTY TURNSCALE_MODULES)
install(TARGETS ${modules} EXPORT turnscaleTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS turnscale RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(
  DIRECTORY src/turnscale
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING
  PATTERN "*.h"
  # What only tests use stays at home.
  PATTERN "synthetic_*.h" EXCLUDE
  PATTERN "*_reference.h" EXCLUDE
  PATTERN "test_*.h" EXCLUDE
  PATTERN "scratch_path.h" EXCLUDE
  PATTERN "refused_field.h" EXCLUDE)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/turnscale)
install(
  EXPORT turnscaleTargets
  NAMESPACE turnscale::
  DESTINATION ${package_dir})
configure_package_config_file(cmake/turnscaleConfig.cmake.in ${PROJECT_BINARY_DIR}/turnscaleConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/turnscaleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/turnscaleConfig.cmake ${PROJECT_BINARY_DIR}/turnscaleConfigVersion.cmake
              cmake/FindOpenCVModules.cmake DESTINATION ${package_dir})
