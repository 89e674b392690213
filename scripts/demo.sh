#!/usr/bin/env bash
# Sets up, builds, and drives the demonstration mission: route 1 through the test field.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/build.sh release kantaro
echo "demo: driving scenarios/route_1.yaml"
verdict=0
build/release/bin/kantaro run scenarios/route_1.yaml --out runs/demo || verdict=$?
if [ -f runs/demo/report.html ]; then
  echo "demo: the report is $PWD/runs/demo/report.html; open it in a browser"
fi
exit "$verdict"
