# SPDX-License-Identifier: MIT
# Writes the compressed manual page OUTPUT of NAME, which is turnscale or turnscale-<command>, from PROGRAM's help text.
# Dated by the latest release in CHANGELOG, so that the same source gives the same page.
string(REPLACE "turnscale-" "turnscale " call "${NAME}")
cmake_path(GET PROGRAM PARENT_PATH folder)
execute_process(COMMAND "${PROGRAM}" --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE ".*\nSubcommands:\n" "" help "${help}")
string(REGEX REPLACE "\n\n.*" "" help "${help}")
if(NAME STREQUAL "turnscale")
  set(what "monocular visual odometry for cars, in metres")
  set(see_also "")
  string(REGEX MATCHALL "(^|\n)  [a-z]+" others "${help}")
  foreach(other IN LISTS others)
    string(STRIP "${other}" other)
    list(APPEND see_also "turnscale-${other}")
  endforeach()
else()
  string(REPLACE "turnscale-" "" command "${NAME}")
  # Its line in the help of the program, as the names of manual pages are written.
  string(REGEX MATCH "(^|\n)  ${command} +([^\n;]*[^\n;.])" line "${help}")
  string(SUBSTRING "${CMAKE_MATCH_2}" 0 1 first)
  string(SUBSTRING "${CMAKE_MATCH_2}" 1 -1 rest)
  string(TOLOWER "${first}" first)
  set(what "${first}${rest}")
  set(see_also turnscale)
endif()
list(SORT see_also)
list(TRANSFORM see_also REPLACE "(.+)" ".BR \\1 (1)")
list(JOIN see_also ",\n" see_also)

file(STRINGS "${CHANGELOG}" releases REGEX "^## [0-9.]+ \\([0-9-]+\\)$" LIMIT_COUNT 1)
string(REGEX REPLACE ".*\\((.*)\\)" "\\1" date "${releases}")
execute_process(COMMAND date --utc --date "${date}" +%s OUTPUT_VARIABLE seconds OUTPUT_STRIP_TRAILING_WHITESPACE
                        COMMAND_ERROR_IS_FATAL ANY)
set(ENV{SOURCE_DATE_EPOCH} ${seconds})
set(ENV{TZ} UTC0)
# Python breaks no lines.
set(ENV{COLUMNS} 2000)
execute_process(
  COMMAND "${HELP2MAN}" --no-info --section=1 --manual=turnscale "--name=${what}" --version-string=${VERSION} "./${call}"
  WORKING_DIRECTORY "${folder}"
  OUTPUT_VARIABLE page COMMAND_ERROR_IS_FATAL ANY)

# What help2man does not know: pages of sub-commands, headings of CLI11 and Python, and examples of several lines.
string(TOUPPER "${NAME}" title)
string(REGEX REPLACE "\n\\.TH [^\n]* \"1\" (\"[^\"]*\") \"[^\"]*\"" "\n.TH ${title} 1 \\1 \"turnscale ${VERSION}\"" page "${page}")
string(REPLACE "\n${call} \\-" "\n${NAME} \\-" page "${page}")
if(command)
  string(REPLACE "\n.B turnscale\n\\fI\\,${command} \\/\\fR" "\n.B ${call}\n" page "${page}")
endif()
string(REPLACE "\n.SS \"Positionals:\"\n" "\n.SH ARGUMENTS\n" page "${page}")
string(REGEX REPLACE "\n\\.SH DESCRIPTION\nusage: ${call} ([^\n]*)\n\\.PP\n" "\n.SH SYNOPSIS\n.B ${call}\n\\1\n.SH DESCRIPTION\n" page
       "${page}")
string(REPLACE "\n.SS \"options:\"\n" "\n.SH OPTIONS\n" page "${page}")
string(REPLACE "\n.SS \"positional arguments:\"\n" "\n.SH ARGUMENTS\n" page "${page}")
string(REPLACE "\n.SS \"Subcommands:\"\n" "\n.SH COMMANDS\n" page "${page}")
string(REPLACE "\n.SS \"Example:\"\n" "\n.SH EXAMPLE\n" page "${page}")
string(REPLACE "\\fB\\-h\\fR,\\-\\-help" "\\fB\\-h\\fR, \\fB\\-\\-help\\fR" page "${page}")
string(REPLACE "\n.IP\n" "\n.IP\n.nf\n" page "${page}")
string(REGEX REPLACE "(\n\\.nf\n[^\n]+(\n[^.\n][^\n]*)*)" "\\1\n.fi" page "${page}")
string(APPEND page ".SH \"SEE ALSO\"\n${see_also}\n")

string(REGEX REPLACE "\\.gz$" "" plain "${OUTPUT}")
file(WRITE "${plain}" "${page}")
execute_process(COMMAND "${GZIP}" -9nf "${plain}" COMMAND_ERROR_IS_FATAL ANY)
