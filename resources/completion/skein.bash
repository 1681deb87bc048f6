# Completion for bash: the programs themselves say what may follow (`skein complete WORD...`), so that this never falls behind them.
# $word as it was typed, without its quotes: $bare, as far as a shell would take it; $quote is the one that it begins with.
_skein_unquote() {
  quote=
  bare=${word//\\/}  # as typed: a blank in a name has a backslash before it
  [[ $word == [\"\']* ]] || return
  quote=${word:0:1} bare=${word:1} bare=${bare%"$quote"}  # the second may be to come
}
# The same of a word that is complete: with the home directory and variables at its beginning.
_skein_expand() {
  _skein_unquote
  if [[ $word == '~/'* ]]; then
    bare=$HOME${bare:1}
  elif [[ $word == [\"\$]* && $bare =~ ^\$\{?([A-Za-z_][A-Za-z_0-9]*)\}?(/.*)?$ ]]; then
    bare=${!BASH_REMATCH[1]}${BASH_REMATCH[2]}
  fi
}
_skein() {
  # bash takes words apart at = and :, the programs do not.
  local words=() glued=0 word bare i quote program
  word=${COMP_WORDS[0]} && _skein_expand && program=$bare
  for ((i = 1; i <= COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]}
    if ((i < COMP_CWORD)); then _skein_expand; else _skein_unquote; fi
    word=$bare
    if [[ ${#words[@]} -gt 0 && ( $word == [=:]* || $glued -eq 1 ) ]]; then
      words[-1]+=$word
    else
      words+=("$word")
    fi
    [[ $word == *[=:] ]] && glued=1 || glued=0
  done
  local typed=${words[-1]} line files=0
  [[ $word == [=:] ]] && word=
  local before=${typed%"$word"}
  COMPREPLY=()
  while IFS= read -r line; do
    if [[ $line == @files ]]; then files=1; else line=${line%%$'\t'*}; COMPREPLY+=("${line#"$before"}"); fi
  done < <("$program" complete "${words[@]}" 2>/dev/null)
  # A name of a run or a robot is a word of the command line, whatever is in it: '$(reboot)' is no command. Of names of
  # files bash quotes what it must, of others not all.
  local plain=1
  for i in "${!COMPREPLY[@]}"; do
    printf -v line %q "${COMPREPLY[i]}"
    [[ $line == "${COMPREPLY[i]}" ]] || plain=0
  done
  if ((files)); then
    ((plain)) && compopt -o filenames 2>/dev/null || plain=0
    while IFS= read -r line; do
      ((plain)) || [[ ! -d ${line/#'~/'/$HOME/} ]] || line+=/
      COMPREPLY+=("$line")
    done < <(compgen -f -- "$word")
  fi
  ((plain)) || for i in "${!COMPREPLY[@]}"; do
    line=${COMPREPLY[i]}
    case $quote in
      \') line=${line//\'/\'\\\'\'} ;;
      \") line=${line//\\/\\\\} line=${line//\"/\\\"} line=${line//\$/\\\$} line=${line//\`/\\\`} ;;
      *) printf -v line %q "$line" && line=${line/#'\~/'/'~/'} ;;
    esac
    COMPREPLY[i]=$line
  done
  [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *[=:/] ]] && compopt -o nospace 2>/dev/null
}
complete -F _skein skein skein-bench
