#!/usr/bin/env bash
# check_links.sh PROGRAM: fails if the program loads a library of the simulator, of the recordings or of the device.
set -euo pipefail

loaded=$(ldd "${1:?which program?}")
# OpenCV's core brings libGLX by itself, which is why GL is not in the list.
if grep -E 'lib(mujoco|OSMesa|EGL|embree|rosbag|opencv_videoio)' <<<"$loaded"; then
  echo "$(basename "$1") must run on the robot, which has none of these" >&2
  exit 1
fi
echo "$(basename "$1") loads nothing of the simulator"
