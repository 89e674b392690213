#!/usr/bin/env bash
# scripts/format.sh [--check]: formats every tracked C++ file, or names those that are not formatted.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case "${1:-}" in
  "") mode=(-i) ;;
  --check) mode=(--dry-run --Werror) ;;
  *)
    echo "format: the only option is --check" >&2
    exit 2
    ;;
esac
scripts/setup.sh
git ls-files -z '*.cpp' '*.hpp' | xargs -0 --no-run-if-empty clang-format-14 "${mode[@]}"
