# Completion for bash: the programs themselves say what may follow (`skein complete WORD...`), so that this never falls behind them.
_skein() {
  # bash takes words apart at = and :, the programs do not.
  local words=() glued=0 word i
  for ((i = 1; i <= COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]//\\/}  # as typed: a blank in a name has a backslash before it
    if [[ ${#words[@]} -gt 0 && ( $word == [=:]* || $glued -eq 1 ) ]]; then
      words[-1]+=$word
    else
      words+=("$word")
    fi
    [[ $word == *[=:] ]] && glued=1 || glued=0
  done
  local typed=${words[-1]} line files=0
  local current=${COMP_WORDS[COMP_CWORD]}
  [[ $current == [=:] ]] && current=
  local before=${typed%"${current//\\/}"}
  COMPREPLY=()
  while IFS= read -r line; do
    if [[ $line == @files ]]; then files=1; else line=${line%%$'\t'*}; COMPREPLY+=("${line#"$before"}"); fi
  done < <("${COMP_WORDS[0]}" complete "${words[@]}" 2>/dev/null)
  # A name of a run or a robot is a word of the command line, whatever is in it: '$(reboot)' is no command.
  for i in "${!COMPREPLY[@]}"; do printf -v "COMPREPLY[i]" %q "${COMPREPLY[i]}"; done
  if ((files)); then
    compopt -o filenames 2>/dev/null
    while IFS= read -r line; do COMPREPLY+=("$line"); done < <(compgen -f -- "$current")
  fi
  [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *[=:] ]] && compopt -o nospace 2>/dev/null
}
complete -F _skein skein skein-bench
