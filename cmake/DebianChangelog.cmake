# SPDX-License-Identifier: MIT
# turnscale_debian_changelog(<markdown> <output> MAINTAINER <name and address>): the releases of CHANGELOG.md, `## 1.2.3
# (2026-01-31)` with lists of `- changes`, in Debian's format, compressed as <output>.
function(turnscale_debian_changelog markdown output)
  cmake_parse_arguments(CHANGELOG "" "MAINTAINER" "" ${ARGN})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${markdown}")
  file(READ "${markdown}" text)
  string(REPLACE ";" "," text "${text}")
  string(REGEX REPLACE "[][`*]" "" text "${text}")
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
      string(APPEND result "  * ${CMAKE_MATCH_1}\n")
    elseif(line MATCHES "^  (.*)")
      string(APPEND result "    ${CMAKE_MATCH_1}\n")
    endif()
  endforeach()
  string(REGEX REPLACE "\\.gz$" "" plain "${output}")
  file(WRITE "${plain}" "${result}${signature}")
  execute_process(COMMAND "${GZIP}" -9nf "${plain}" COMMAND_ERROR_IS_FATAL ANY)
endfunction()
