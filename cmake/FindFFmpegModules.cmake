# SPDX-License-Identifier: MIT
# Finds single libraries of FFmpeg, which has no CMake package. Each component becomes the target
# FFmpegModules::<component>. FFmpegModules::headers are those of all of them, for programs that load the libraries when
# they need them. FFmpegModules_RUNTIME_PACKAGES: the Debian packages of the libraries.

include("${CMAKE_CURRENT_LIST_DIR}/ImportedComponent.cmake")

set(FFmpegModules_RUNTIME_PACKAGES "")
if(NOT TARGET FFmpegModules::headers)
  add_library(FFmpegModules::headers INTERFACE IMPORTED)
endif()
foreach(module IN LISTS FFmpegModules_FIND_COMPONENTS)
  find_path(FFmpegModules_${module}_INCLUDE_DIR lib${module}/${module}.h)
  find_library(FFmpegModules_${module}_LIBRARY ${module})
  mark_as_advanced(FFmpegModules_${module}_INCLUDE_DIR FFmpegModules_${module}_LIBRARY)
  imported_component(FFmpegModules ${module} FFmpegModules_${module}_INCLUDE_DIR FFmpegModules_${module}_LIBRARY)
  if(FFmpegModules_${module}_FOUND)
    target_include_directories(FFmpegModules::headers INTERFACE "${FFmpegModules_${module}_INCLUDE_DIR}")
    file(REAL_PATH "${FFmpegModules_${module}_LIBRARY}" library)
    if(library MATCHES "\\.so\\.([0-9]+)")
      list(APPEND FFmpegModules_RUNTIME_PACKAGES lib${module}${CMAKE_MATCH_1})
    endif()
  endif()
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(FFmpegModules HANDLE_COMPONENTS REASON_FAILURE_MESSAGE
                                  "install libavformat-dev, libavcodec-dev, libavutil-dev and libswscale-dev")
