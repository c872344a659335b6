# SPDX-License-Identifier: MIT
# Writes the C++ file OUTPUT with the commit of the folder SOURCE: of git, else of the archive that `git archive` made, else
# none. Keeps the file where it would not change.
set(commit "")
if(EXISTS "${SOURCE}/.git")
  # No lock: others may use the repository at the same time.
  set(ENV{GIT_OPTIONAL_LOCKS} 0)
  execute_process(
    COMMAND git describe --tags --match "v[0-9]*" --always --long --dirty
    WORKING_DIRECTORY "${SOURCE}"
    OUTPUT_VARIABLE commit
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
elseif(EXISTS "${SOURCE}/cmake/archived_commit.txt")
  file(STRINGS "${SOURCE}/cmake/archived_commit.txt" archived)
  foreach(line IN LISTS archived)
    # The first line is empty in archives of commits after no tag.
    if(commit STREQUAL "" AND NOT line MATCHES "[$%]")
      string(STRIP "${line}" commit)
    endif()
  endforeach()
endif()
if(NOT commit MATCHES "^[A-Za-z0-9._+-]*$")
  set(commit "")
endif()
set(text
    "// SPDX-License-Identifier: MIT\n#include \"build_commit.h\"\n\nnamespace turnscale {\n\nconst char* BuildCommit() { return \"${commit}\"; }\n\n}  // namespace turnscale\n"
)
set(written "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" written)
endif()
if(NOT written STREQUAL text)
  file(WRITE "${OUTPUT}" "${text}")
endif()
