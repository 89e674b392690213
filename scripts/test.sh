#!/usr/bin/env bash
# Sets up, builds, and runs every test but the soak tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/build.sh release
ctest --preset release --parallel "$(nproc)"
