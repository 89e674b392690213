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
broken=()
for target in "${targets[@]}"; do
  corpus=build/fuzz/corpus/$target
  seeds=fuzz/corpus/$target
  mkdir -p "$corpus"
  echo "fuzz: $target for $seconds s"
  if "build/fuzz/bin/$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="build/fuzz/found/$target-" "$corpus" "$seeds" >"build/fuzz/log/$target" 2>&1; then
    sed -n 's/^Done \([0-9]*\) runs.*/fuzz:   \1 inputs, none broke it/p' "build/fuzz/log/$target"
  else
    grep -m 1 -A 20 'ERROR' "build/fuzz/log/$target" || tail -n 20 "build/fuzz/log/$target"
    broken+=("$target")
  fi
done

if [ "${#broken[@]}" -gt 0 ]; then
  echo "fuzz: broken: ${broken[*]}; the inputs are in build/fuzz/found" >&2
  exit 1
fi
