#!/usr/bin/env bash
# Installs what scripts/packages.txt lists, as root or through sudo. Does nothing where all of it is there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fail() {
  echo "setup: $1" >&2
  exit 2
}

wanted_packages() { sed -e 's/#.*//' -e 's/[[:space:]]*$//' -e '/^$/d' scripts/packages.txt; }

missing_packages() {
  local installed
  installed=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' | sed -n 's/^installed //p' | sort -u)
  comm -23 <(wanted_packages | sort -u) <(echo "$installed")
}

as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif [ -t 0 ]; then
    sudo "$@"
  else
    sudo -n "$@"
  fi
}

apt() { as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 "$@"; }

command -v apt-get >/dev/null ||
  fail "this is no Debian system (no apt-get): use Debian 12, on a machine or in a container"
mapfile -t missing < <(missing_packages)
if [ "${#missing[@]}" -eq 0 ]; then
  echo "setup: all $(wanted_packages | wc -l) packages are there"
  exit 0
fi
if [ "$(id -u)" -ne 0 ] && ! command -v sudo >/dev/null; then
  fail "${#missing[@]} Debian packages are missing and there is no sudo: run scripts/setup.sh once as root"
fi

echo "setup: installing ${#missing[@]} Debian packages: ${missing[*]}"
apt update </dev/null || echo "setup: going on with the package lists that are there" >&2
apt install -y --no-install-recommends "${missing[@]}" </dev/null ||
  fail "apt-get failed (see above): it needs Debian 12, a mirror it can reach, and root or sudo rights"
echo "setup: done"
