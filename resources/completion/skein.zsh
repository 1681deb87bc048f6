#compdef skein skein-bench
# Completion for zsh: the programs themselves say what may follow (`skein complete WORD...`), so that this never falls behind them.
_skein() {
  local -a lines whole open typed
  local line word program=${(Q)words[1]}
  [[ $program == \~/* ]] && program=$HOME${program#\~}
  typed=("${(@Q)words[2,CURRENT]}")  # without backslashes and quotes, of which the last may be open
  typed[-1]=${typed[-1]#[\'\"]}
  lines=("${(@f)$(_call_program candidates ${(q)program} complete "${(@q)typed}" 2>/dev/null)}")
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
