# SPDX-License-Identifier: MIT
# Text as Debian's files have it.

# turnscale_wrap(<variable> <text> [<indent>]): the words of the text in lines of at most 76 characters, of which all but the
# first begin with the indent.
function(turnscale_wrap variable text)
  set(lines "")
  set(line "")
  string(REGEX MATCHALL "[^ \n]+" words "${text}")
  foreach(word IN LISTS words)
    string(LENGTH "${line} ${word}" length)
    if(line STREQUAL "")
      set(line "${word}")
    elseif(length GREATER 76)
      string(APPEND lines "${line}\n")
      set(line "${ARGV2}${word}")
    else()
      string(APPEND line " ${word}")
    endif()
  endforeach()
  set(${variable} "${lines}${line}" PARENT_SCOPE)
endfunction()

# turnscale_debian_changelog(<markdown> <output> MAINTAINER <name and address>): the releases of CHANGELOG.md, `## 1.2.3
# (2026-01-31)` with lists of `- changes`, in Debian's format, compressed as <output>.
function(turnscale_debian_changelog markdown output)
  cmake_parse_arguments(CHANGELOG "" "MAINTAINER" "" ${ARGN})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${markdown}")
  file(READ "${markdown}" text)
  # CMake's lists end at semicolons.
  string(ASCII 1 semicolon)
  string(REPLACE ";" "${semicolon}" text "${text}")
  string(REGEX REPLACE "[][`*]" "" text "${text}")
  string(REPLACE "\n  " " " text "${text}")
  string(REPLACE "\n" ";" lines "${text}")
  set(result "")
  set(signature "")
  foreach(line IN LISTS lines)
    if(line MATCHES "^## ([0-9.]+) \\((.*)\\)$")
      set(version ${CMAKE_MATCH_1})
      execute_process(
        COMMAND ${CMAKE_COMMAND} -E env LC_ALL=C date --utc --rfc-email --date "${CMAKE_MATCH_2}"
        OUTPUT_VARIABLE date
        OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
      string(APPEND result "${signature}turnscale (${version}) unstable; urgency=medium\n\n")
      set(signature "\n -- ${CHANGELOG_MAINTAINER}  ${date}\n\n")
    elseif(line MATCHES "^- (.*)")
      turnscale_wrap(change "${CMAKE_MATCH_1}" "    ")
      string(APPEND result "  * ${change}\n")
    endif()
  endforeach()
  string(REGEX REPLACE "\n+$" "\n" result "${result}${signature}")
  string(REPLACE "${semicolon}" ";" result "${result}")
  string(REGEX REPLACE "\\.gz$" "" plain "${output}")
  file(WRITE "${plain}" "${result}")
  execute_process(COMMAND "${GZIP}" -9nf "${plain}" COMMAND_ERROR_IS_FATAL ANY)
endfunction()
