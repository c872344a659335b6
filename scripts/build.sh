# SPDX-License-Identifier: MIT
# For scripts that build: sourced, from the project's folder, with `log` naming a file.

# Passes on one line each time another tenth of the steps "[n/m]" or tests "n/m Test" is done.
progress() {
  local what=$1 line shown=0 tenth
  while IFS= read -r line; do
    [[ $line =~ ^\ *\[?([0-9]+)/([0-9]+) ]] || continue
    tenth=$((10 * BASH_REMATCH[1] / BASH_REMATCH[2]))
    if ((tenth > shown && BASH_REMATCH[2] >= 20)); then
      echo "$what: ${BASH_REMATCH[1]} of ${BASH_REMATCH[2]}"
      shown=$tenth
    fi
  done
}

configure() { cmake "$@" >"$log" 2>&1 || { cat "$log"; echo "$0: cannot configure"; return 1; }; }

# build PRESET [TARGET [CMAKE ARGUMENT...]]: configures and builds; says only how far it is, or what failed.
build() {
  local preset=$1 target=${2-all}
  configure --preset "$preset" "${@:3}" || return 1
  # In a folder that was configured for another compiler, CMake loses all other settings of the preset.
  if grep -q 'require your cache to be deleted' "$log"; then
    configure --fresh --preset "$preset" "${@:3}" || return 1
  fi
  cmake --build --preset "$preset" --target "$target" --parallel "$(nproc)" 2>&1 | tee "$log" | progress building || {
    sed -n '/^FAILED:/,$p' "$log"
    echo "$0: cannot build"
    return 1
  }
}
