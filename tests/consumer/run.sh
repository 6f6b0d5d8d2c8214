#!/bin/sh
# usage: run.sh installed|subdirectory SOURCE_DIR BUILD_DIR WORK_DIR: Quoin as a project outside uses it.
set -e
source=$2
build=$3
work=$4
rm -rf "$work"
mkdir -p "$work"
case $1 in
  installed)
    # Only the parts of the contract and the laws: the host is no concern of a consumer.
    for part in plugin_api contact_models/elastic contact_models/coulomb_slip contact_models/fracture_energy; do
      cmake -DCMAKE_INSTALL_PREFIX="$work/usr" -P "$build/$part/cmake_install.cmake" >/dev/null
    done
    # In another place than it was configured for: the tree is relocatable.
    mv "$work/usr" "$work/elsewhere"
    cmake -S "$source/tests/consumer/find_package" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/elsewhere" >"$work/log"
    cmake --build "$work/build" >>"$work/log"
    (cd "$work/build" && ctest --output-on-failure)
    pc=$(find "$work/elsewhere" -name quoin.pc)
    if command -v pkg-config >/dev/null; then
      flags=$(PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --define-prefix --cflags quoin)
      cc -std=c99 $flags "$source/tests/consumer/host.c" -o "$work/by_pkg_config"
      "$work/by_pkg_config"
    else
      echo "pkg-config: skipped, not installed"
    fi
    if python3 -c 'import numpy' 2>/dev/null; then
      share=$work/elsewhere/share/quoin
      PYTHONPATH=$share:$share/adapters/shared:$share/adapters/lammps:$share/adapters/yade PYTHONDONTWRITEBYTECODE=1 \
        python3 -c 'import atom_joints, cube_scene, joints'
    else
      echo "adapters in Python: skipped, NumPy is not installed"
    fi
    ;;
  subdirectory)
    cmake -S "$source/tests/consumer/subdirectory" -B "$work/build" -DQUOIN_SOURCE_DIR="$source" -DBUILD_TESTING=OFF \
      >"$work/log" || { cat "$work/log"; exit 1; }
    cmake --build "$work/build" >>"$work/log" || { cat "$work/log"; exit 1; }
    "$work/build/consumer"
    ;;
esac
