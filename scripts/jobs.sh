#!/usr/bin/env bash
# Prints how many compilers run at once: one a core, and no more than there are 1.5 GiB of free memory for.
set -euo pipefail
cores=$(nproc)
by_memory=$(awk '/^MemAvailable:/ { print int($2 / 1572864) }' /proc/meminfo)
jobs=$((cores < by_memory ? cores : by_memory))
echo $((jobs > 1 ? jobs : 1))
