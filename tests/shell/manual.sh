#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# manual.sh PROGRAM FOLDER: every sub-command in the program's help has a page in FOLDER, which names each of its options and
# which man formats without a warning.
set -uo pipefail

program=$1 folder=$2 failed=0
fail() { echo "$*"; failed=1; }

mapfile -t commands < <("$program" --help | sed -nE '/^Subcommands:/,/^$/s/^  ([a-z]+).*/\1/p')
[[ ${#commands[@]} -ge 6 ]] || fail "sub-commands in the help: ${commands[*]}"
pages=(turnscale "${commands[@]/#/turnscale-}")
for page in "${pages[@]}"; do
  file=$folder/$page.1.gz
  # Its help needs Dask.
  if [[ $page == turnscale-batch ]] && ! "$program" batch --help >/dev/null 2>&1; then continue; fi
  [[ -s $file ]] || { fail "no page $page(1)"; continue; }
  text=$(zcat "$file")
  [[ $text == *"$page \\- "* ]] || fail "$page(1) has no name"
  call=("$program")
  [[ $page == turnscale ]] || call+=("${page#turnscale-}")
  plain=${text//\\-/-}
  plain=${plain//\\fB/}
  plain=${plain//\\fR/}
  for option in $("${call[@]}" --help | grep -oE '^  (-[a-z],)?--[a-z-]+' | grep -oE -- '--.*'); do
    grep -qE -- "^([^ ]+ )?$option( |$)" <<<"$plain" || fail "$page(1) lacks $option"
  done
  if command -v man >/dev/null; then
    warnings=$(LC_ALL=C.UTF-8 MANROFFSEQ='' MANWIDTH=80 man --warnings -l -Tutf8 -Z "$file" 2>&1 >/dev/null | grep -v "can't break line")
    [[ -z $warnings ]] || fail "$page(1): $warnings"
  fi
done
exit $failed
