# SPDX-License-Identifier: MIT
# `find_package(turnscale)` for others: the modules as turnscale::<module>, their headers, and what they need.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/turnscale)
foreach(part IN ITEMS library io laboratory simulation)
  get_property(modules GLOBAL PROPERTY TURNSCALE_MODULES_OF_${part})
  if(NOT modules)
    continue()
  endif()
  install(TARGETS ${modules} EXPORT turnscale_${part} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(
    EXPORT turnscale_${part}
    NAMESPACE turnscale::
    DESTINATION ${package_dir})
  foreach(target IN LISTS modules)
    get_target_property(folder ${target} SOURCE_DIR)
    install(
      DIRECTORY ${folder}
      DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/turnscale
      FILES_MATCHING
      PATTERN "*.h"
      # What only tests use stays at home.
      PATTERN "synthetic_*.h" EXCLUDE
      PATTERN "*_reference.h" EXCLUDE
      PATTERN "test_*.h" EXCLUDE
      PATTERN "refused_field.h" EXCLUDE)
  endforeach()
endforeach()
if(TURNSCALE_BUILD_PROGRAM)
  install(TARGETS turnscale RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(
    DIRECTORY fleet/turnscale_batch
    DESTINATION ${CMAKE_INSTALL_DATADIR}/turnscale/fleet
    FILES_MATCHING
    PATTERN "*.py")
endif()

configure_package_config_file(cmake/turnscaleConfig.cmake.in ${PROJECT_BINARY_DIR}/turnscaleConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/turnscaleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/turnscaleConfig.cmake ${PROJECT_BINARY_DIR}/turnscaleConfigVersion.cmake
              cmake/FindCompressors.cmake cmake/FindCppHttplib.cmake cmake/FindFFmpegModules.cmake
              cmake/FindOpenCVModules.cmake
        DESTINATION ${package_dir})
