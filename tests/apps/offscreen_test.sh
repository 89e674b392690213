#!/usr/bin/env bash
# offscreen_test.sh KANTARO SOURCE STUB: takes the program's OpenGL away in every way. It is to end with exit code 3, one line on
# standard error that says what is missing, nothing on standard output, and no run folder. STUB is a folder with a libOSMesa.so.8
# that does not work (stub_osmesa.cpp).
set -u
kantaro=$(realpath "$1")
mission=$(realpath "$2")/tests/apps/short_mission.yaml
stub=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0
mkdir no_osmesa no_egl
echo "no library" >no_osmesa/libOSMesa.so.8
echo "no library" >no_egl/libEGL.so.1

# ends CODE PATTERN VARIABLE=VALUE...: PATTERN is an extended regular expression for the whole line.
ends() {
  local wanted=$1 pattern=$2
  shift 2
  rm -rf out
  env "$@" "$kantaro" run "$mission" --out out >stdout 2>stderr
  local code=$?
  local complaint=""
  [ "$code" -eq "$wanted" ] || complaint="exit code $code"
  [ "$(wc -l <stderr)" -eq 1 ] || complaint="$complaint, $(wc -l <stderr) lines on standard error"
  grep -Eqx "kantaro: $pattern" stderr || complaint="$complaint, not \"$pattern\""
  [ ! -s stdout ] || complaint="$complaint, something on standard output"
  [ ! -e out ] || complaint="$complaint, a run folder"
  [ -z "$complaint" ] && return
  echo "$*: ${complaint#, }"
  head -c 400 stderr
  failures=$((failures + 1))
}

unrendered="internal fault: cameras cannot be rendered:"
ends 3 "$unrendered OSMesa does not start \(Segmentation fault; .*GALLIUM_DRIVER=none\)" GALLIUM_DRIVER=none
ends 3 "$unrendered OSMesa cannot be opened \(.*\)" LD_LIBRARY_PATH=no_osmesa
ends 3 "$unrendered OSMesa does not start \(it gives no OpenGL context\)" LD_LIBRARY_PATH="$stub" STUB_OSMESA=no_context
ends 3 "$unrendered OpenGL lacks gl[A-Za-z]+" LD_LIBRARY_PATH="$stub" STUB_OSMESA=no_functions
ends 3 "$unrendered EGL cannot be opened \(.*\)" KANTARO_GL=egl LD_LIBRARY_PATH=no_egl
ends 3 "$unrendered EGL has no driver that starts without a display \(error 0x[0-9a-f]+\)" KANTARO_GL=egl \
  __EGL_VENDOR_LIBRARY_DIRS="$work" __EGL_VENDOR_LIBRARY_FILENAMES=
ends 2 'KANTARO_GL: "metal" is none of osmesa, egl' KANTARO_GL=metal
ends 2 'LP_NATIVE_VECTOR_WIDTH: Mesa cannot draw with "512"; 128 and 256 are right' LP_NATIVE_VECTOR_WIDTH=512
[ "$failures" -eq 0 ] && echo "each missing OpenGL is told"
exit "$failures"
