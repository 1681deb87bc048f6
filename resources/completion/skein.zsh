#compdef skein skein-bench
# Completion for zsh: the programs themselves say what may follow (`skein complete WORD...`), so that this never falls behind them.
_skein() {
  local -a lines whole open
  local line word
  lines=("${(@f)$(_call_program candidates ${(q)words[1]} complete "${(@q)words[2,CURRENT]}" 2>/dev/null)}")
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
