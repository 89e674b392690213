#!/usr/bin/env bash
# check_includes.sh CHECKOUT: names every #include that crosses a wall between rooms. Exits 1 if there is one.
set -euo pipefail
cd "${1:?which checkout?}"

rooms='base|network|robot|perception|navigation|sim|scenarios|apps'

# What a room may include of others. tests/ROOM obeys the row of its room.
declare -A may_include=(
  [base]='base'
  [network]='base|network'
  [robot]='base|robot'
  [perception]='base|robot|perception'
  [navigation]='base|network|robot|perception|navigation'
  [sim]='base|network|robot|sim'
  [scenarios]='base|network|robot|perception|navigation|sim|scenarios'
  [apps]='base|scenarios|apps'
  [tests/base]='base'
  [tests/network]='base|network'
  [tests/perception]='base|robot|perception'
  [tests/navigation]='base|network|robot|perception|navigation'
)

# Libraries that belong to one place each: a pattern of headers, and the paths that may include them.
libraries=(
  'mujoco/|GL/|EGL/|embree3/ sim|bench/sim|tests/sim'
  'urdf_|tinyxml robot'
  'rosbag/|ros/|[a-z]+_msgs/ robot/recording'
  'opencv2/videoio|termios robot/device'
  'boost/ network|sim'
  'CLI/ apps'
)

# Prints FILE:LINE:#include ... for every include that begins with the pattern, among the files named on stdin.
includes() {
  local start="^[[:space:]]*#[[:space:]]*include[[:space:]]*[<\"]($1)"
  xargs --no-run-if-empty awk -v start="$start" '$0 ~ start { print FILENAME ":" FNR ": " $0 }'
}
sources() { find "$@" -type f \( -name '*.hpp' -o -name '*.cpp' \) | sed 's,^\./,,'; }
drop() { awk -v pattern="$1" '$0 !~ pattern'; }
explain() { awk -v reason="$1" '{ print $0 "  <- " reason }'; }

breaches() {
  local room entry headers owners
  for room in "${!may_include[@]}"; do
    [ -d "$room" ] || continue
    sources "$room" | includes "($rooms)/" | drop "include[[:space:]]*[<\"](${may_include[$room]})/" |
      explain "$room may include only ${may_include[$room]}"
  done
  for entry in "${libraries[@]}"; do
    read -r headers owners <<<"$entry"
    sources . | drop "^build/|^(${owners})[/._]" | includes "$headers" | explain "belongs to $owners alone"
  done
}

found=$(breaches)
if [ -n "$found" ]; then
  echo "$found"
  exit 1
fi
echo "every include keeps to its room"
