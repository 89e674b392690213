#!/usr/bin/env bash
# check_includes.sh must see each kind of breach in a made-up checkout, and pass a clean one.
set -euo pipefail
check=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/check_includes.sh
checkout=$(mktemp -d)
trap 'rm -rf "$checkout"' EXIT
mkdir -p "$checkout"/{network,robot,perception,navigation,sim,scenarios,tests/perception}

echo '#include "robot/readings.hpp"' >"$checkout/perception/clean.hpp"
echo '#include "sim/twin.hpp"' >"$checkout/scenarios/clean.cpp"
echo '#include <mujoco/mujoco.h>' >"$checkout/sim/clean.cpp"
bash "$check" "$checkout" >/dev/null || { echo "a clean checkout was refused" >&2; exit 1; }

must_see() {
  echo "$2" >"$checkout/$1"
  if bash "$check" "$checkout" >/dev/null; then
    echo "not seen: $2 in $1" >&2
    exit 1
  fi
  rm "$checkout/$1"
}
must_see perception/cheat.cpp '#include "sim/ground_truth.hpp"'
must_see perception/map.cpp '#include "network/network.hpp"'
must_see navigation/cheat.hpp '  #  include "sim/twin.hpp"'
must_see navigation/physics.cpp '#include <mujoco/mujoco.h>'
must_see robot/map.hpp '#include "network/network.hpp"'
must_see network/judge.cpp '#include "scenarios/judge.hpp"'
must_see sim/eyes.cpp '#include "perception/ring_finder.hpp"'
must_see tests/perception/rays.cpp '#include <embree3/rtcore.h>'
must_see tests/perception/world.cpp '#include "sim/sewer.hpp"'
must_see perception/bags.cpp '#include <rosbag/bag.h>'
echo "every kind of breach is seen"
