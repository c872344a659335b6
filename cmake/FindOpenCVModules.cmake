# SPDX-License-Identifier: MIT
# Finds single OpenCV modules without OpenCV's own CMake package, which Debian ships only with the whole of OpenCV.
# Each component becomes the target OpenCVModules::<component>.

include("${CMAKE_CURRENT_LIST_DIR}/ImportedComponent.cmake")

find_path(OpenCVModules_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
mark_as_advanced(OpenCVModules_INCLUDE_DIR)

foreach(module IN LISTS OpenCVModules_FIND_COMPONENTS)
  find_library(OpenCVModules_${module}_LIBRARY opencv_${module})
  mark_as_advanced(OpenCVModules_${module}_LIBRARY)
  if(EXISTS "${OpenCVModules_INCLUDE_DIR}/opencv2/${module}.hpp")
    imported_component(OpenCVModules ${module} OpenCVModules_INCLUDE_DIR OpenCVModules_${module}_LIBRARY)
  endif()
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVModules REQUIRED_VARS OpenCVModules_INCLUDE_DIR HANDLE_COMPONENTS)
