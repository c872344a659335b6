# SPDX-License-Identifier: MIT
# Headers that most sources read, compiled once for the library, once for what is built with the program, and for test
# programs once for each level of optimization. The library's do not depend on what else is built, so that a compiler
# cache finds its objects in every configuration. Sources include what they use all the same: presets without this
# option compile them.

set(TURNSCALE_PRECOMPILED
    <algorithm>
    <cmath>
    <filesystem>
    <fstream>
    <functional>
    <iostream>
    <map>
    <memory>
    <optional>
    <random>
    <set>
    <sstream>
    <string>
    <thread>
    <unordered_map>
    <vector>
    <Eigen/Dense>
    <opencv2/core.hpp>
    <yaml-cpp/yaml.h>
    <common_expressions.h>)
set(TURNSCALE_PRECOMPILED_LINKS Eigen3::Eigen OpenCVModules::core yaml-cpp)
set(TURNSCALE_PRECOMPILED_PROGRAM ${TURNSCALE_PRECOMPILED} <fmt/format.h> <nlohmann/json.hpp>)
set(TURNSCALE_PRECOMPILED_PROGRAM_LINKS ${TURNSCALE_PRECOMPILED_LINKS} fmt::fmt nlohmann_json::nlohmann_json)

# turnscale_precompile(<target> HEADERS <header>... LINKS <library>...): the target whose precompiled headers others use.
function(turnscale_precompile target)
  cmake_parse_arguments(PCH "" "" "HEADERS;LINKS" ${ARGN})
  file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp CONTENT "// The sources of other targets follow.\n")
  add_library(${target} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp)
  target_link_libraries(${target} PRIVATE ${PCH_LINKS} turnscale_build_flags)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/cmake)
  target_precompile_headers(${target} PRIVATE ${PCH_HEADERS})
endfunction()

# turnscale_reuse(<target> <precompiled>): the sources of the target begin with the precompiled headers.
function(turnscale_reuse target precompiled)
  if(NOT TARGET ${precompiled})
    return()
  endif()
  target_precompile_headers(${target} REUSE_FROM ${precompiled})
  # A compiler cache reads the headers themselves.
  target_include_directories(${target} SYSTEM PRIVATE $<TARGET_PROPERTY:${precompiled},INCLUDE_DIRECTORIES>)
endfunction()

if(TURNSCALE_PRECOMPILE)
  turnscale_precompile(turnscale_precompiled HEADERS ${TURNSCALE_PRECOMPILED} LINKS ${TURNSCALE_PRECOMPILED_LINKS})
  set_target_properties(turnscale_precompiled PROPERTIES POSITION_INDEPENDENT_CODE ON)
endif()
if(TURNSCALE_PRECOMPILE AND TURNSCALE_BUILD_PROGRAM)
  turnscale_precompile(turnscale_precompiled_program HEADERS ${TURNSCALE_PRECOMPILED_PROGRAM} LINKS
                       ${TURNSCALE_PRECOMPILED_PROGRAM_LINKS})
  set_target_properties(turnscale_precompiled_program PROPERTIES POSITION_INDEPENDENT_CODE ON)
endif()
if(TURNSCALE_PRECOMPILE AND TURNSCALE_BUILD_TESTS)
  set(test_headers ${TURNSCALE_PRECOMPILED})
  set(test_links ${TURNSCALE_PRECOMPILED_LINKS})
  if(TURNSCALE_BUILD_PROGRAM)
    set(test_headers ${TURNSCALE_PRECOMPILED_PROGRAM})
    set(test_links ${TURNSCALE_PRECOMPILED_PROGRAM_LINKS})
  endif()
  foreach(level IN ITEMS O0 O1)
    turnscale_precompile(turnscale_precompiled_${level} HEADERS ${test_headers} <gtest/gtest.h> LINKS
                         ${test_links} GTest::gtest_main)
    target_compile_options(turnscale_precompiled_${level} PRIVATE $<$<CONFIG:Release>:-${level}>)
  endforeach()
endif()
