# SPDX-License-Identifier: MIT
# How a module (one folder of src/turnscale) becomes a library and a test program.

add_library(turnscale_build_flags INTERFACE)
target_compile_features(turnscale_build_flags INTERFACE cxx_std_20)
target_compile_options(
  turnscale_build_flags
  INTERFACE -Wall
            -Wextra
            -Wpedantic
            -Wshadow
            -Wconversion
            -Wno-sign-conversion
            -Wnon-virtual-dtor
            # The same bits on every machine: no fused multiply-add that the source does not ask for.
            -ffp-contract=off
            # Paths in messages of tests start at the project's folder, and the same sources give the same objects wherever
            # that lies.
            -fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=
            $<$<BOOL:${TURNSCALE_WARNINGS_AS_ERRORS}>:-Werror>
            $<$<BOOL:${TURNSCALE_NATIVE}>:-march=native>)
# Types with Eigen's members are laid out in the same way in libraries and programs that are compiled for AVX or not.
target_compile_definitions(turnscale_build_flags INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
if(TURNSCALE_SANITIZE)
  target_compile_options(turnscale_build_flags INTERFACE -fsanitize=${TURNSCALE_SANITIZE} -fno-omit-frame-pointer
                                                         -fno-sanitize-recover=all)
  if(TURNSCALE_SANITIZE MATCHES "address")
    # Checks of pointers. With them, compiling takes one and a half times as long and the tests three times. The address
    # sanitizer reports accesses through null and out of bounds, too; misaligned ones stay unnoticed.
    target_compile_options(turnscale_build_flags INTERFACE -fno-sanitize=null,alignment,object-size,vptr,pointer-overflow)
  endif()
  # The instrumentation hides from GCC what is initialised: it then warns inside the standard library.
  target_compile_options(turnscale_build_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(turnscale_build_flags INTERFACE -fsanitize=${TURNSCALE_SANITIZE})
endif()

# turnscale_module(<module> SOURCES ... [HEADERS_ONLY] [USES <public libraries>] [USES_PRIVATELY <libraries>])
# Modules name only modules below them in USES; ARCHITECTURE.md shows the order. TURNSCALE_PART is the part of the
# package that the module belongs to.
function(turnscale_module module)
  cmake_parse_arguments(MODULE "" "" "SOURCES;USES;USES_PRIVATELY" ${ARGN})
  set(target turnscale_${module})
  add_library(${target} STATIC ${MODULE_SOURCES})
  add_library(turnscale::${module} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${module} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>
                                              $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_definitions(${target} PUBLIC EIGEN_MAX_ALIGN_BYTES=16)
  target_link_libraries(${target} PUBLIC ${MODULE_USES} PRIVATE ${MODULE_USES_PRIVATELY}
                                                              $<BUILD_INTERFACE:turnscale_build_flags>)
  if(TURNSCALE_PART STREQUAL "library")
    turnscale_reuse(${target} turnscale_precompiled)
  else()
    turnscale_reuse(${target} turnscale_precompiled_program)
  endif()
  set_property(GLOBAL APPEND PROPERTY TURNSCALE_MODULES_OF_${TURNSCALE_PART} ${target})
endfunction()

# turnscale_tests(<module> [OPTIMIZED] SOURCES <test files> [USES <extra libraries>] [LABELS <ctest labels> [SHARDS
# <number>]]): one GoogleTest program. OPTIMIZED where that saves more time in the tests than it costs to compile. It
# may do so where only the libraries compute: the linker can take the test program's copy of a function in a header,
# such as Eigen's, for their calls too. Without labels these are unit tests: the target unit_tests builds them. CTest
# runs the tests of a program in one process, or in as many as there are shards, since loading the libraries takes
# longer than most of the tests. Shards have the longest tests: they start first, so that none is left to run alone.
function(turnscale_tests module)
  if(NOT TURNSCALE_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(TESTS "OPTIMIZED" "" "SOURCES;USES;LABELS;SHARDS" ${ARGN})
  set(target ${module}_test)
  add_executable(${target} ${TESTS_SOURCES})
  # -O0 compiles in about half the time of -O3. The libraries that are tested keep their own level.
  set(level O0)
  if(TESTS_OPTIMIZED)
    set(level O1)
  endif()
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-${level}>)
  if(TARGET turnscale_${module})
    target_link_libraries(${target} PRIVATE turnscale::${module})
  endif()
  target_link_libraries(${target} PRIVATE ${TESTS_USES} GTest::gtest_main turnscale_build_flags)
  turnscale_reuse(${target} turnscale_precompiled_${level})
  if(TESTS_SHARDS)
    math(EXPR last "${TESTS_SHARDS} - 1")
    foreach(shard RANGE ${last})
      add_test(NAME ${target}.${shard} COMMAND ${target})
      set_tests_properties(
        ${target}.${shard}
        PROPERTIES LABELS "${TESTS_LABELS}" TIMEOUT 900 COST 100
                   ENVIRONMENT "GTEST_TOTAL_SHARDS=${TESTS_SHARDS};GTEST_SHARD_INDEX=${shard}")
    endforeach()
    return()
  endif()
  add_test(NAME ${target} COMMAND ${target})
  if(TESTS_LABELS)
    set_tests_properties(${target} PROPERTIES LABELS "${TESTS_LABELS}" TIMEOUT 900)
    return()
  endif()
  if(NOT TARGET unit_tests)
    add_custom_target(unit_tests)
  endif()
  add_dependencies(unit_tests ${target})
  set_tests_properties(${target} PROPERTIES LABELS unit TIMEOUT 900)
endfunction()

# turnscale_runs(<target> <program>): running the target needs the program, compiling it does not. With add_dependencies,
# its sources would wait for the program; other generators than Ninja do not find the rule of a file in another folder.
function(turnscale_runs target program)
  if(CMAKE_GENERATOR MATCHES "Ninja")
    set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS $<TARGET_FILE:${program}>)
  else()
    add_dependencies(${target} ${program})
  endif()
endfunction()
