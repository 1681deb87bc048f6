# completion.zsh SOURCE BUILD: the completion as zsh runs it, in a terminal of its own: what stands on the line after it.
zmodload zsh/zpty
dots=$(mktemp -d) && trap 'rm -rf $dots' EXIT
mkdir $dots/functions && cp $1/resources/completion/skein.zsh $dots/functions/_skein
cat >$dots/.zshrc <<'RC'
PROMPT= ; unsetopt beep prompt_sp
fpath=($ZDOTDIR/functions $fpath)
autoload -Uz compinit && compinit -D -u
# One key for both: none waits while the completion works.
complete-line() { zle expand-or-complete; print -r -- "<$BUFFER>"; BUFFER= }
zle -N complete-line && bindkey '^G' complete-line
print ready
RC
zpty shell "HOME=${(q)2} ZDOTDIR=$dots TERM=dumb zsh -i"
zpty -r -m shell line '*ready*' || exit 1
failed=0
# completes WORDS LINE: what stands on the line once WORDS are completed.
completes() {
  zpty -w -n shell "$1"$'\a'
  zpty -r -m shell line '*<*>*'
  line=${line##*<} line=${line%%>*}
  [[ $line == $2 ]] || { print -r -- "zsh: $1: [$line], expected [$2]"; failed=1 }
}
completes 'skein repl' 'skein replay '
completes 'skein run lemn' 'skein run lemniscate '
completes 'skein run min' 'skein run mine.toml '
completes 'skein run platoon --set arena.wid' 'skein run platoon --set arena.width='
completes 'skein run platoon --set avoidance.kind=pl' 'skein run platoon --set avoidance.kind=plan '
completes 'skein robots pi' 'skein robots ping '
completes 'skein-bench loo' 'skein-bench loopback '
completes '~/bin/skein repl' '~/bin/skein replay '
completes '$HOME/bin/skein repl' '$HOME/bin/skein replay '
completes 'skein runs verify --runs-dir lab\ one/runs b' 'skein runs verify --runs-dir lab\ one/runs b '
completes 'skein runs verify --runs-dir $PWD/lab\ one/runs b' 'skein runs verify --runs-dir $PWD/lab\ one/runs b '
completes 'skein runs verify --runs-dir="$PWD/lab one/runs" b' 'skein runs verify --runs-dir="$PWD/lab one/runs" b '
completes 'skein runs verify a\ ' 'skein runs verify a\ \$run\` '
completes "skein runs verify 'a " "skein runs verify 'a \$run\`' "
completes 'skein runs verify "a ' 'skein runs verify "a \$run\`" '
exit $failed
