#!/usr/bin/env bash
# scripts/fuzz.sh SECONDS [TARGET...]: runs each fuzz target that long from its corpus in fuzz/corpus/TARGET.
# An input that breaks a target stays in build/fuzz/found; new inputs that reach new code in build/fuzz/corpus.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=${1:?how many seconds for each target?}
shift

scripts/build.sh fuzz fuzzers
if [ "$#" -eq 0 ]; then
  mapfile -t targets < <(cd build/fuzz/bin && ls -d fuzz_*)
else
  targets=("$@")
fi

mkdir -p build/fuzz/found build/fuzz/log
# A target has a core to itself; as many run beside each other as there are cores.
fuzz() {
  local target=$1 corpus=build/fuzz/corpus/$1 log=build/fuzz/log/$1 input
  mkdir -p "$corpus"
  if "build/fuzz/bin/$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="build/fuzz/found/$target-" "$corpus" "fuzz/corpus/$target" >"$log" 2>&1; then
    sed -n "s/^Done \([0-9]*\) runs.*/fuzz: $target, \1 inputs, none broke it/p" "$log"
  else
    echo "fuzz: $target broke"
    grep -m 1 -A 20 'ERROR' "$log" || tail -n 20 "$log"
    input=$(sed -n 's/.*Test unit written to //p' "$log" | tail -n 1)
    # A machine that is gone tomorrow says what broke it.
    [ -z "$input" ] || { echo "fuzz: $input, gzip | base64:" && gzip -c "$input" | base64; }
    return 1
  fi
}

broken=()
for target in "${targets[@]}"; do
  rm -f "build/fuzz/log/$target.broke"
  while [ "$(jobs -rp | wc -l)" -ge "$(nproc)" ]; do wait -n || true; done
  { fuzz "$target" || touch "build/fuzz/log/$target.broke"; } &
done
wait
for target in "${targets[@]}"; do
  if [ -e "build/fuzz/log/$target.broke" ]; then broken+=("$target"); fi
done

if [ "${#broken[@]}" -gt 0 ]; then
  echo "fuzz: broken: ${broken[*]}; the inputs are in build/fuzz/found" >&2
  exit 1
fi
