# SPDX-License-Identifier: MIT
# Finds compression libraries without a CMake package of their own. Components: deflate, lz4, turbojpeg, zstd. Each
# becomes the target Compressors::<component>.

include("${CMAKE_CURRENT_LIST_DIR}/ImportedComponent.cmake")

set(header_of_deflate libdeflate.h)
set(header_of_lz4 lz4frame.h)
set(header_of_turbojpeg turbojpeg.h)
set(header_of_zstd zstd.h)

foreach(library IN LISTS Compressors_FIND_COMPONENTS)
  find_path(Compressors_${library}_INCLUDE_DIR ${header_of_${library}})
  find_library(Compressors_${library}_LIBRARY ${library})
  mark_as_advanced(Compressors_${library}_INCLUDE_DIR Compressors_${library}_LIBRARY)
  imported_component(Compressors ${library} Compressors_${library}_INCLUDE_DIR Compressors_${library}_LIBRARY)
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Compressors HANDLE_COMPONENTS REASON_FAILURE_MESSAGE
                                  "install libdeflate-dev, liblz4-dev, libturbojpeg0-dev and libzstd-dev")
