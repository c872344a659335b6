# SPDX-License-Identifier: MIT
# cpp-httplib as Debian has it: a shared library whose header has to see the macros that it was built with. Gives
# cpphttplib::cpphttplib.
find_package(PkgConfig QUIET)
if(PKG_CONFIG_FOUND)
  pkg_check_modules(CppHttplib QUIET IMPORTED_TARGET GLOBAL cpp-httplib)
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(CppHttplib REQUIRED_VARS CppHttplib_LINK_LIBRARIES VERSION_VAR CppHttplib_VERSION)
if(CppHttplib_FOUND AND NOT TARGET cpphttplib::cpphttplib)
  add_library(cpphttplib::cpphttplib ALIAS PkgConfig::CppHttplib)
endif()
