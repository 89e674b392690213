#!/usr/bin/env bash
# same_pictures_test.sh KANTARO SOURCE VARIABLE=VALUE...: the cameras see the same, to the bit, with each of these in the
# environment as with none. Mesa's software driver draws. Skips (77) where EGL is asked for and there is none.
set -eu
kantaro=$(realpath "$1")
mission=$(realpath "$2")/tests/apps/short_mission.yaml
shift 2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# render FOLDER [VARIABLE=VALUE]
render() {
  env LIBGL_ALWAYS_SOFTWARE=1 ${2+"$2"} "$kantaro" render "$mission" --pipe P --chainage 1 --out "$1" >/dev/null 2>stderr
}
render plain
[ "$(find plain -name '*.png' | wc -l)" -gt 0 ]
for setting in "$@"; do
  if ! render changed "$setting"; then
    cat stderr
    if grep -q "EGL cannot be opened\|EGL has no driver" stderr; then exit 77; fi
    exit 1
  fi
  diff -r plain changed
  rm -r changed
  echo "the same pictures with $setting"
done
