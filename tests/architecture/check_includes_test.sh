#!/usr/bin/env bash
# check_includes.sh must pass a clean made-up checkout, and see each kind of breach in a broken one.
set -euo pipefail
check=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/check_includes.sh
checkout=$(mktemp -d)
trap 'rm -rf "$checkout"' EXIT
mkdir -p "$checkout"/{network,robot,perception,navigation,sim,scenarios,tests/perception}

echo '#include "robot/readings.hpp"' >"$checkout/perception/clean.hpp"
echo '#include "sim/twin.hpp"' >"$checkout/scenarios/clean.cpp"
echo '#include <mujoco/mujoco.h>' >"$checkout/sim/clean.cpp"
bash "$check" "$checkout" >/dev/null || {
  echo "a clean checkout was refused" >&2
  exit 1
}

breaches=(
  'perception/cheat.cpp        #include "sim/ground_truth.hpp"'
  'perception/map.cpp          #include "network/network.hpp"'
  'perception/bags.cpp         #include <rosbag/bag.h>'
  'perception/eyes.cpp         #include <opencv2/videoio.hpp>'
  'navigation/cheat.hpp        #  include "sim/twin.hpp"'
  'navigation/physics.cpp      #include <mujoco/mujoco.h>'
  'robot/map.hpp               #include "network/network.hpp"'
  'network/judge.cpp           #include "scenarios/judge.hpp"'
  'sim/eyes.cpp                #include "perception/ring_finder.hpp"'
  'tests/perception/rays.cpp   #include <embree3/rtcore.h>'
  'tests/perception/world.cpp  #include "sim/sewer.hpp"'
)
for breach in "${breaches[@]}"; do
  read -r file line <<<"$breach"
  echo "$line" >"$checkout/$file"
done

seen=$(bash "$check" "$checkout") && {
  echo "a broken checkout was passed" >&2
  exit 1
}
for breach in "${breaches[@]}"; do
  read -r file line <<<"$breach"
  grep -qF "$file:1: $line  <- " <<<"$seen" || {
    echo "not seen: $line in $file" >&2
    exit 1
  }
done
if grep -q clean <<<"$seen"; then
  echo "a clean file was refused" >&2
  exit 1
fi
echo "every kind of breach is seen"
