#compdef skein skein-bench
# Completion for zsh: the programs themselves say what may follow (`skein complete WORD...`), so that this never falls behind them.
_skein() {
  local -a lines whole open typed match mbegin mend
  local line word MATCH
  integer k MBEGIN MEND
  typed=("${(@Q)words[1,CURRENT]}")  # without backslashes and quotes, of which the last may be open
  typed[-1]=${typed[-1]#[\'\"]}
  for ((k = 1; k < CURRENT; ++k)); do  # the home directory, and variables at the beginning of a word
    if [[ $words[k] == \~/* ]]; then
      typed[k]=$HOME${typed[k]#\~}
    elif [[ $words[k] =~ '^(--[a-z-]+=)?"?\$\{?([A-Za-z_][A-Za-z_0-9]*)\}?(/|"|$)' ]]; then
      typed[k]=$match[1]${(P)match[2]}${${typed[k]#*\$(\{|)$match[2]}#\}}
    fi
  done
  lines=("${(@f)$(_call_program candidates ${(q)typed[1]} complete "${(@q)typed[2,-1]}" 2>/dev/null)}")
  for line in $lines; do
    if [[ $line == @files ]]; then _files; continue; fi
    word=${line%%$'\t'*} line=${line#*$'\t'}
    line=${word//:/\\:}${line:+:$line}
    if [[ $word == *[=:] ]]; then open+=("$line"); else whole+=("$line"); fi
  done
  (( $#whole )) && _describe -t values 'skein' whole
  (( $#open )) && _describe -t keys 'skein' open -S ''
}
_skein "$@"
