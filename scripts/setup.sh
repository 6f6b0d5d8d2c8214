# Sourced by demo and test, which name what they need. Debian 12.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# What the program and the laws are built with, and what draws their pictures.
program="g++ cmake ninja-build pkg-config libhwy-dev libssl-dev coinor-libclp-dev libtomlplusplus-dev libcli11-dev libfmt-dev libeigen3-dev libopenblas-serial-dev
  nlohmann-json3-dev libboost-dev librandom123-dev zlib1g-dev gnuplot-nox"

# Those of the packages that are missing; as root or with sudo.
install_packages() {
  local package missing="" as_root=""
  for package in "$@"; do
    dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  echo "Installing:$missing"
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "Run as root, or install sudo, so that these can be installed:$missing" >&2; exit 1; }
    as_root="sudo"
  fi
  $as_root apt-get update -q
  # shellcheck disable=SC2086  # a list of packages
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
}
