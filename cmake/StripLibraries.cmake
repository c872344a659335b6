# SPDX-License-Identifier: MIT
# Run by cpack before it makes the packages: static libraries keep the symbols to link with, and no more.
file(GLOB_RECURSE libraries ${CPACK_TEMPORARY_DIRECTORY}/*.a)
foreach(library IN LISTS libraries)
  execute_process(COMMAND strip --strip-debug --remove-section=.comment --remove-section=.note --enable-deterministic-archives
                          ${library} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
