# SPDX-License-Identifier: MIT
# What is installed, in components (TurnscalePackages.cmake makes a Debian package of each): development, which is
# `find_package(turnscale)` for others: the modules as turnscale::<module>, their headers, and what they need; program;
# simulator.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/turnscale)
foreach(part IN ITEMS library io laboratory simulation)
  get_property(modules GLOBAL PROPERTY TURNSCALE_MODULES_OF_${part})
  if(NOT modules)
    continue()
  endif()
  install(TARGETS ${modules} EXPORT turnscale_${part} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
                                                               COMPONENT development)
  install(
    EXPORT turnscale_${part}
    NAMESPACE turnscale::
    DESTINATION ${package_dir}
    COMPONENT development)
  foreach(target IN LISTS modules)
    get_target_property(folder ${target} SOURCE_DIR)
    install(
      DIRECTORY ${folder}
      DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/turnscale
      COMPONENT development
      FILES_MATCHING
      PATTERN "*.h"
      # What only tests use stays at home.
      PATTERN "synthetic_*.h" EXCLUDE
      PATTERN "*_reference.h" EXCLUDE
      PATTERN "test_*.h" EXCLUDE
      PATTERN "refused_field.h" EXCLUDE
      # These need the headers of FFmpeg.
      PATTERN "ffmpeg.h" EXCLUDE
      PATTERN "codec_pointers.h" EXCLUDE)
  endforeach()
endforeach()
if(TURNSCALE_BUILD_PROGRAM)
  install(TARGETS turnscale RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  install(
    DIRECTORY fleet/turnscale_batch
    DESTINATION ${CMAKE_INSTALL_DATADIR}/turnscale/fleet
    COMPONENT program
    FILES_MATCHING
    PATTERN "*.py"
    PATTERN "__pycache__" EXCLUDE)
  install(
    FILES apps/turnscale/completion.bash
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
    RENAME turnscale
    COMPONENT program)
endif()
if(TARGET turnscale_simulator)
  install(TARGETS turnscale_simulator RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/turnscale COMPONENT simulator)
endif()

configure_package_config_file(cmake/turnscaleConfig.cmake.in ${PROJECT_BINARY_DIR}/turnscaleConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/turnscaleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/turnscaleConfig.cmake ${PROJECT_BINARY_DIR}/turnscaleConfigVersion.cmake
              cmake/FindCompressors.cmake cmake/FindCppHttplib.cmake cmake/FindOpenCVModules.cmake
              cmake/ImportedComponent.cmake
        DESTINATION ${package_dir}
        COMPONENT development)
