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

# build PRESET [ARGUMENT...]: configures the preset in build/release where nothing is built yet, and builds. There files are
# compiled in batches, in about six tenths of the time (cmake/quick_build.cmake); a tree that is built keeps its way. Names
# that clash within a batch are no fault of the code: targets where a batch fails are compiled file by file.
build() {
  local preset=$1 log apart="" failed; shift
  log=$(mktemp)
  if [ -e build/release/build.ninja ]; then cmake --preset "$preset" >/dev/null; else cmake --preset "$preset" -DQUOIN_QUICK_BUILD=ON >/dev/null; fi
  until cmake --build build/release "$@" 2>&1 | tee "$log"; do
    failed=$(sed -n 's#^FAILED: .*CMakeFiles/\([^/]*\)\.dir/Unity/.*#\1#p' "$log" | sort -u | paste -sd ';')
    [ -n "$failed" ] || { rm -f "$log"; return 1; }
    apart="$apart;$failed"
    echo "Compiled again, file by file: $failed"
    cmake --preset "$preset" -DQUOIN_FILE_BY_FILE="$apart" >/dev/null
  done
  rm -f "$log"
}
