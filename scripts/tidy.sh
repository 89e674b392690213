#!/usr/bin/env bash
# scripts/tidy.sh [REGEX]: runs clang-tidy over the sources, or those whose path matches the regular expression.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh
# A folder of its own: clang cannot read GCC's precompiled headers.
cmake -S . -B build/tidy -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >/dev/null
rooms='(base|network|robot|perception|navigation|sim|scenarios|apps)'
run-clang-tidy-14 -quiet -p build/tidy -j "$(scripts/jobs.sh)" "${1:-^$PWD/$rooms/}"
