# SPDX-License-Identifier: MIT
# turnscale_commit_source(<variable>): a source file with the commit, which the target turnscale_commit writes in every
# build, but only where the commit has changed: then one small file is compiled, and the programs are linked again.
function(turnscale_commit_source variable)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/build_commit.cpp)
  add_custom_target(
    turnscale_commit
    COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -DOUTPUT=${source} -P
            ${PROJECT_SOURCE_DIR}/cmake/WriteCommit.cmake
    BYPRODUCTS ${source}
    VERBATIM)
  set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  set(${variable} ${source} PARENT_SCOPE)
endfunction()
