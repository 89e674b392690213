#!/usr/bin/env bash
# bad_input_test.sh KANTARO SOURCE: gives the program bad input of every kind. Each is to end with exit code 2, one line on
# standard error that names what is wrong and where, nothing on standard output, and no output left behind.
set -u
kantaro=$(realpath "$1")
source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

# refused NAME PATTERN ARGUMENT...: PATTERN is an extended regular expression for the whole line.
refused() {
  local name=$1 pattern=$2
  shift 2
  rm -rf out runs
  "$kantaro" "$@" >stdout 2>stderr
  local code=$?
  local complaint=""
  [ "$code" -eq 2 ] || complaint="exit code $code"
  [ "$(wc -l <stderr)" -eq 1 ] || complaint="$complaint, $(wc -l <stderr) lines on standard error"
  grep -Eqx "kantaro: $pattern" stderr || complaint="$complaint, not \"$pattern\""
  [ ! -s stdout ] || complaint="$complaint, something on standard output"
  if [ -e out ] || [ -e runs ]; then complaint="$complaint, output left behind"; fi
  [ -z "$complaint" ] && return
  echo "$name: ${complaint#, }"
  head -c 400 stderr
  failures=$((failures + 1))
}

# scenario FILE [SED EXPRESSION]: a good scenario beside a good network, changed.
scenario() {
  sed "${2:-}" >"$1" <<'YAML'
name: mission
network: network.yaml
robot: ROBOT
start: {manhole: A, pipe: P, chainage_m: 0.6}
goal: {manhole: B}
time_limit_s: 20
variation:
  friction: [0.4, 0.8]
YAML
  sed -i "s|ROBOT|${3:-$source/models/kantaro}|" "$1"
}

network() {
  sed "${2:-}" >"$1" <<'YAML'
name: one pipe
manholes:
  - {name: A, position_m: [0, 0, 0.05], depth_m: 1.2, bench_height: crown}
  - {name: B, position_m: [5, 0, 0.0], depth_m: 1.2, bench_height: crown}
pipes:
  - name: P
    from: A
    to: B
    diameter_mm: 300
    material: pvc
YAML
}

network network.yaml
scenario good.yaml
"$kantaro" network network.yaml >/dev/null || { echo "the good network is refused"; failures=1; }

# Usage.
refused "no command" "COMMAND: none is given; known are run, firmware, replay, suite, network, generate, render, calibrate, experiment"
refused "unknown command" 'COMMAND: "fly" is not one; known are .*' fly
refused "no scenario" ".*SCENARIO is required.*" run
refused "calibrate from no recording" ".*good.yaml: not a ROS 1 bag.*" calibrate --from good.yaml --robot "$source/models/kantaro" --to out.yaml
refused "unknown option" ".*--colour.*" run good.yaml --colour red
refused "seed that is no number" '--seed: "seven" is not a number from 0 to [0-9]+' run good.yaml --seed seven --out out
refused "negative seed" '--seed: "-1" is not a number.*' run good.yaml --seed -1 --out out
refused "seed with a tail" '--seed: "7x" is not a number.*' run good.yaml --seed 7x --out out
refused "no seeds" '--seeds: "0" is not a number from 1.*' suite good.yaml --seeds 0 --out out
refused "no such sense" '--blind: "smell" is no sensor.*' run good.yaml --blind smell --out out
refused "no such hardware" '--hardware: "ship:me" is none of sim.*' run good.yaml --hardware ship:me --out out
refused "chainage that is no number" '--chainage: "far" is not a number.*' render good.yaml --pipe P --chainage far --out out
refused "chainage beyond the pipe" '--chainage: 90 m is outside pipe "P".*' render good.yaml --pipe P --chainage 90 --out out
refused "pipe that is not there" '--pipe: the network has no pipe "Q"' render good.yaml --pipe Q --chainage 1 --out out

# Files that are not there, or are something else.
refused "missing scenario" "nowhere.yaml: no such file" run nowhere.yaml --out out
refused "unknown layout" "LAYOUT: \"blob\" is none of grid, tree, city" generate blob --to out/made.yaml
refused "no pipes to make" "--pipes: \"0\" is not a number from 1 to 1000000" generate tree --pipes 0 --to out/made.yaml
refused "two sizes of a network" "--pipes excludes --length-km" generate tree --pipes 5 --length-km 1 --to out/made.yaml
refused "network in an unknown form" "--to: .* does not end in .yaml, .*" generate tree --to out/made.txt
refused "missing network" "nowhere.inp: no such file" network nowhere.inp
scenario bad.yaml 's/network.yaml/nowhere.yaml/'
refused "scenario with a missing network" "bad.yaml:2: network: no such file: nowhere.yaml" run bad.yaml --out out
scenario bad.yaml '' nowhere
refused "scenario with a missing robot" ".*nowhere.*" run bad.yaml --out out
refused "folder for a file" ".*: this is a folder.*" run . --out out
mkdir empty
refused "suite of an empty folder" "empty: the folder holds no scenario.*" suite empty --out out
refused "missing baseline" "nowhere.json: no such file" suite good.yaml --baseline nowhere.json --out out
echo '{"cases": 3}' >baseline.json
refused "baseline of another kind" "baseline.json: cases: not a suite.json.*" suite good.yaml --baseline baseline.json --out out

# Scenarios.
scenario bad.yaml 's/time_limit_s: 20/time_limit_s: soon/'
refused "wrong type" 'bad.yaml:6: time_limit_s: "soon" is not a number' run bad.yaml --out out
scenario bad.yaml 's/friction/fiction/'
refused "unknown key" "bad.yaml:8: variation.fiction: unknown key.*" run bad.yaml --out out
scenario bad.yaml '/^goal/d'
refused "missing key" 'bad.yaml:1: the key "goal" is missing' run bad.yaml --out out
scenario bad.yaml 's/manhole: B/manhole: Z/'
refused "unknown manhole" 'bad.yaml:5: goal.manhole: the network has no manhole "Z"' run bad.yaml --out out

# Networks.
network bad.yaml 's/diameter_mm: 300/diameter_mm: -300/'
refused "negative diameter" "bad.yaml:9: .*diameter_mm.*" network bad.yaml --to out
network bad.yaml 's/to: B/to: Z/'
refused "pipe to an unknown manhole" 'bad.yaml:8: .*"?Z"?.*' network bad.yaml --to out
head -c 50000000 /dev/urandom >noise.yaml
refused "50 MB of noise as YAML" "noise.yaml:[0-9]+: .*" network noise.yaml --to out
cp noise.yaml noise.inp
refused "50 MB of noise as SWMM" "noise.inp:.*" network noise.inp --to out
refused "50 MB of noise as a scenario" "noise.yaml:[0-9]+: .*" run noise.yaml --out out
rm noise.*
{
  echo 'a: &a [x, x, x, x, x, x, x, x, x]'
  previous=a
  for name in b c d e f g h i j k; do
    echo "$name: &$name [*$previous, *$previous, *$previous, *$previous, *$previous, *$previous, *$previous, *$previous, *$previous]"
    previous=$name
  done
} >bomb.yaml
refused "alias bomb" "bomb.yaml:1: anchors and aliases are not accepted.*" network bomb.yaml --to out
refused "alias bomb as a scenario" "bomb.yaml:1: anchors and aliases are not accepted.*" run bomb.yaml --out out
swmm=$source/models/networks/epa_example1.inp
head -c $(($(grep -b '^\[XSECTIONS\]' "$swmm" | cut -d: -f1) - 40)) "$swmm" >cut.inp
refused "SWMM file cut in the middle" "cut.inp:.*" network cut.inp --to out
refused "unknown ending" "notes.txt: .*" network notes.txt
refused "conversion to another format" '--to: "out.inp" does not end in .yaml.*' network network.yaml --to out.inp

# The robot's files.
cp -r "$source/models/kantaro" robot
sed -i '0,/width_px: 704/s//width_px: 0/' robot/cameras.yaml
scenario bad.yaml '' robot
refused "image size of 0" "robot/cameras.yaml:[0-9]+: .*width_px.*" run bad.yaml --out out

# Recordings.
refused "missing recording" "nowhere.bag: no such file" replay nowhere.bag --out out
refused "text as a recording" "good.yaml: not a ROS 1 bag of format 2.0" replay good.yaml --out out
: >empty.bag
refused "empty recording" "empty.bag: the file is empty" replay empty.bag
refused "recording as hardware that is none" "good.yaml: not a ROS 1 bag of format 2.0" run good.yaml --hardware replay:good.yaml --out out
refused "hardware without a file" '--hardware: "replay:" is none of sim, replay:RECORDING.*' run good.yaml --hardware replay: --out out
printf '#ROSBAG V2.0\n\377\377\377\377' >huge.bag
refused "recording of a hostile size" "huge.bag: the file is cut off" replay huge.bag
/usr/bin/python3 -c 'import rosbag, std_msgs.msg
with rosbag.Bag("foreign.bag", "w") as bag: bag.write("/chatter", std_msgs.msg.String("hi"))
with rosbag.Bag("packed.bag", "w", compression="bz2") as bag: bag.write("/chatter", std_msgs.msg.String("hi"))'
refused "another robot's bag" "foreign.bag: not a recording of KANTARO: .*" replay foreign.bag
refused "compressed bag" "packed.bag: is compressed: .rosbag decompress. makes it readable" replay packed.bag
exec 9>held.recording.lock && flock 9
refused "a folder that another run records into" "held: another process is writing there: .*" run good.yaml --record --out held
exec 9>&-

# A folder that is not ours stays as it is.
mkdir precious && echo thesis >precious/chapter1.txt
refused "unknown experiment" 'NAME: "flight" is no experiment; known are all, .*' experiment flight --out out
refused "experiment without runs" '--count: "0" is not a number .*' experiment locomotion --count 0 --out out
refused "experiment with an unknown case" '--only: "loop" is no case; known are straight, .*' experiment locomotion --only loop --robot "$source/models/kantaro" --out out
refused "page from no measurement" "nowhere/locomotion.json: no such file" experiment all --from nowhere --page out
echo '{"experiment": "locomotion", "rows": 3}' >locomotion.json
refused "page from another file" './locomotion.json: not a result of the experiment "locomotion"' experiment all --from . --page out
refused "experiment without a robot" "nowhere/cameras.yaml: no such file" experiment locomotion --robot nowhere --out out
refused "another's folder as output" "precious: holds files of another kind.*" run good.yaml --out precious
[ "$(cat precious/chapter1.txt)" = thesis ] || { echo "another's file was touched"; failures=$((failures + 1)); }

[ "$failures" -eq 0 ] && echo "every bad input was refused"
exit "$failures"
