# Sourced by demo and test: installs what is missing on Debian 12, then configures and builds the release preset.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages="g++ cmake ninja-build pkg-config libhwy-dev libtomlplusplus-dev libcli11-dev libfmt-dev libeigen3-dev
  nlohmann-json3-dev libgtest-dev libgmock-dev libbenchmark-dev gnuplot-nox python3 python3-numpy python3-matplotlib
  python3-lammps liblammps-dev
  clang clang-format clang-tidy"

missing=""
for package in $packages; do
  dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing="$missing $package"
done
if [ -n "$missing" ]; then
  echo "Installing:$missing"
  as_root=""
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "Run as root, or install sudo, so that these can be installed:$missing" >&2; exit 1; }
    as_root="sudo"
  fi
  $as_root apt-get update -q
  # shellcheck disable=SC2086  # a list of packages
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
fi

cmake --preset release >/dev/null
