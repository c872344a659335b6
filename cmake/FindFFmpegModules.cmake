# SPDX-License-Identifier: MIT
# Finds single libraries of FFmpeg, which has no CMake package. Each component becomes the target
# FFmpegModules::<component>.

include("${CMAKE_CURRENT_LIST_DIR}/ImportedComponent.cmake")

foreach(module IN LISTS FFmpegModules_FIND_COMPONENTS)
  find_path(FFmpegModules_${module}_INCLUDE_DIR lib${module}/${module}.h)
  find_library(FFmpegModules_${module}_LIBRARY ${module})
  mark_as_advanced(FFmpegModules_${module}_INCLUDE_DIR FFmpegModules_${module}_LIBRARY)
  imported_component(FFmpegModules ${module} FFmpegModules_${module}_INCLUDE_DIR FFmpegModules_${module}_LIBRARY)
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(FFmpegModules HANDLE_COMPONENTS REASON_FAILURE_MESSAGE
                                  "install libavformat-dev, libavcodec-dev, libavutil-dev and libswscale-dev")
