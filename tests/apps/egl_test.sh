#!/usr/bin/env bash
# egl_test.sh KANTARO SOURCE: with KANTARO_GL=egl the cameras see what they see with OSMesa, to the bit where Mesa's software
# driver stands behind both. Skips (77) only where there is no EGL.
set -eu
kantaro=$(realpath "$1")
mission=$(realpath "$2")/tests/apps/short_mission.yaml
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

render() { "$kantaro" render "$mission" --pipe P --chainage 1 --out "$1" >/dev/null 2>stderr; }
export LIBGL_ALWAYS_SOFTWARE=1
if ! KANTARO_GL=egl render egl; then
  cat stderr
  if grep -q "EGL cannot be opened\|EGL has no driver" stderr; then exit 77; fi
  exit 1
fi
render osmesa
diff -r osmesa egl
[ "$(find egl -name '*.png' | wc -l)" -gt 0 ]
echo "EGL and OSMesa give the same pictures"
