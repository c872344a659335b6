#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# completion.sh PROGRAM COMPLETION: what bash completes at the end of a command line. Skipped (77) without bash-completion.
set -uo pipefail

[[ -r /usr/share/bash-completion/bash_completion ]] || { echo "no bash-completion"; exit 77; }
program=$1
# shellcheck disable=SC1090,SC1091
source /usr/share/bash-completion/bash_completion
# shellcheck disable=SC1090
source "$2"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
touch car.yaml camera.yaml
failed=0

# completes EXPECTED WORD...: the line `turnscale WORD...`, with the cursor at the end of the last word.
completes() {
  local expected=$1 got
  COMP_WORDS=("$program" "${@:2}")
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  COMP_LINE="${COMP_WORDS[*]}" COMP_TYPE=9 COMP_KEY=9
  COMP_LINE=${COMP_LINE/ = /=}
  COMP_POINT=${#COMP_LINE}
  COMPREPLY=()
  _turnscale turnscale
  got=$(printf '%s\n' ${COMPREPLY[@]+"${COMPREPLY[@]}"} | sort | tr '\n' ' ')
  # shellcheck disable=SC2053
  if [[ " $got" != $expected ]]; then
    echo "turnscale ${*:2}: completed by '$got', expected '$expected'"
    failed=1
  fi
}

completes '* calibrate * run * view *' ''
completes ' rescale run ' r
completes ' --version ' --v
completes '* --camera-height *--lever-arm *' run drive --
completes ' --lever-arm --lever-arm-sigma ' run drive --lever
completes ' paper smoothed turns ' run drive --method ''
completes ' paper ' run drive --method pa
# As the shell splits --method=pa.
completes ' paper ' run drive --method = pa
completes ' camera.yaml car.yaml ' run drive --vehicle ''
completes ' camera.yaml ' run drive --camera cam
completes '  ' run drive --lever-arm ''
completes '  ' run drive --topic ''
completes ' camera.yaml car.yaml ' run drive --quiet ''
completes ' camera.yaml car.yaml ' run ''
if "$program" --help | grep -q '^  simulate '; then completes ' garage street ' simulate ''; fi
completes ' camera.yaml car.yaml ' nothing ''
exit $failed
