# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# Completes sub-commands, options, their choices and files of turnscale, all from the help texts of the program itself.

_turnscale() {
  local cur prev words cword split
  _init_completion -s || return
  local program=${words[0]/#\~/$HOME} command='' i
  for ((i = 1; i < cword; i++)); do
    [[ ${words[i]} == -* ]] || { command=${words[i]}; break; }
  done
  if [[ -z $command ]]; then
    local commands
    commands=$("$program" --help 2>/dev/null | sed -nE '/^Subcommands:/,/^$/s/^  ([a-z]+).*/\1/p')
    mapfile -t COMPREPLY < <(compgen -W "$commands --help --version" -- "$cur")
    return
  fi

  local help choices='' line
  help=$("$program" "$command" --help 2>/dev/null)
  if [[ $prev == -* ]]; then
    # The option's name, its type and choices; what it does begins after two spaces or on the next line.
    line=$(sed -nE 's/^  (-[^,]+,)?('"$prev"')([ =].*)?$/\3/p' <<<"$help" | head -n 1)
    line=${line%%  *}
    if [[ $line =~ \{([^}]*)\} ]]; then
      choices=${BASH_REMATCH[1]}
    elif [[ $line =~ ^\ (FLOAT|INT|UINT|N|S|ADDRESS) || ($line == ' '* && $prev =~ ^--(topic|start|end|start-time|live-address|origin|camera-height)$) ]]; then
      return
    elif [[ $line =~ ^\ [A-Z] && ! $line =~ ^\ (Excludes|Needs): ]]; then
      _filedir
      return
    fi
  fi
  if [[ -z $choices ]]; then
    if $split; then return; fi
    if [[ $cur == -* ]]; then
      local options
      options=$(grep -oE '^  (-[a-zA-Z], ?)?--[a-z][a-z0-9-]*' <<<"$help" | grep -oE -- '--.*')
      mapfile -t COMPREPLY < <(compgen -W "$options" -- "$cur")
      return
    fi
    choices=$(sed -nE '/^Positionals:/,/^$/s/^  [a-zA-Z_]+ TEXT:\{([^}]*)\}.*/\1/p' <<<"$help")
  fi
  if [[ -n $choices ]]; then
    mapfile -t COMPREPLY < <(compgen -W "${choices//,/ }" -- "$cur")
  else
    _filedir
  fi
} && complete -F _turnscale turnscale
