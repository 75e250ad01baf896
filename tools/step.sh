#!/bin/sh
# step.sh HEADLINE LOG COMMAND...: runs a command quietly. Prints the headline, then the last line of the output and the
# time; if the command fails, its output and a clear last line. Status 77 (this machine cannot do it) is no failure. On a
# terminal the last line of the output so far stands behind the headline, so that a long step is seen to go on.
headline=$1
log=$2
shift 2
mkdir -p "$(dirname "$log")"
printf '%-44s ' "$headline"
start=$(date +%s)
if [ -t 1 ]; then
  clear=$(printf '\r\033[K')
  while sleep 5; do
    printf '%s%-44s %3d s: %.60s' "$clear" "$headline" $(($(date +%s) - start)) "$(tail -n 1 "$log" | tr -d '\r')"
  done &
  shown=$!
  trap 'kill $shown' EXIT
fi
"$@" >"$log" 2>&1 </dev/null
status=$?
seconds=$(($(date +%s) - start))
if [ -t 1 ]; then
  kill $shown
  trap - EXIT
  printf '%s%-44s ' "$clear" "$headline"
fi
if [ $status -eq 77 ]; then
  status=0
fi
if [ $status -eq 0 ]; then
  printf '%s (%d s)\n' "$(tail -n 1 "$log")" $seconds
else
  printf 'FAILED (%d s)\n' $seconds
  tail -n 60 "$log"
  echo "$headline: failed; whole output in $log"
fi
exit $status
