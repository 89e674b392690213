#!/usr/bin/env bash
# scripts/build.sh PRESET [TARGET...]: sets up, configures and builds into build/PRESET.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=${1:?which preset? release, debug, asan, tsan or fuzz}
shift

scripts/setup.sh
if [ -f "build/$preset/build.ninja" ]; then
  echo "build: build/$preset is configured; ninja configures again if a CMake file changed"
else
  cmake --preset "$preset"
fi
# `all` stands in for an empty list of targets.
cmake --build --preset "$preset" --parallel "$(scripts/jobs.sh)" --target "${@:-all}"
