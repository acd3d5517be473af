# Completion for bash. What may follow says the tool itself (TOOL --complete WORD...), so that this file knows no options.
_leeway() {
  local word words=()
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do # bash takes --ship=NAME for three words
    [[ $word == "=" ]] || words+=("$word")
  done
  mapfile -t COMPREPLY < <("${1/#\~/$HOME}" --complete "${words[@]}" "$2" 2>/dev/null)
  local kind=${COMPREPLY[0]:-}
  COMPREPLY=("${COMPREPLY[@]:1}")
  [[ $kind == files ]] || return 0
  if ((${#COMPREPLY[@]} == 0)); then
    compopt -o default 2>/dev/null # readline's own completion of file names
  else
    compopt -o filenames 2>/dev/null
    mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -f -- "$2")
  fi
  return 0
} && complete -F _leeway @LEEWAY_TOOLS@
