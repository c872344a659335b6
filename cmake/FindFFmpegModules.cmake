# SPDX-License-Identifier: MIT
# Finds single libraries of FFmpeg, which has no CMake package. Each component becomes the target
# FFmpegModules::<component>.

foreach(module IN LISTS FFmpegModules_FIND_COMPONENTS)
  find_path(FFmpegModules_${module}_INCLUDE_DIR lib${module}/${module}.h)
  find_library(FFmpegModules_${module}_LIBRARY ${module})
  mark_as_advanced(FFmpegModules_${module}_INCLUDE_DIR FFmpegModules_${module}_LIBRARY)
  if(FFmpegModules_${module}_INCLUDE_DIR AND FFmpegModules_${module}_LIBRARY)
    set(FFmpegModules_${module}_FOUND TRUE)
    if(NOT TARGET FFmpegModules::${module})
      add_library(FFmpegModules::${module} UNKNOWN IMPORTED)
      set_target_properties(
        FFmpegModules::${module} PROPERTIES IMPORTED_LOCATION "${FFmpegModules_${module}_LIBRARY}"
                                            INTERFACE_INCLUDE_DIRECTORIES "${FFmpegModules_${module}_INCLUDE_DIR}")
    endif()
  endif()
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(FFmpegModules HANDLE_COMPONENTS REASON_FAILURE_MESSAGE
                                  "install libavformat-dev, libavcodec-dev, libavutil-dev and libswscale-dev")
