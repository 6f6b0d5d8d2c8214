#!/bin/sh
# usage: run.sh installed|program|subdirectory|demo SOURCE_DIR BUILD_DIR WORK_DIR LAW...: Quoin as a project outside uses it.
set -e
source=$2
build=$3
work=$4
way=$1
shift 4
rm -rf "$work"
mkdir -p "$work"
case $way in
  installed)
    # Only the parts of the contract and the laws: the host is no concern of a consumer.
    for part in plugin_api contact_models; do
      cmake -DCMAKE_INSTALL_PREFIX="$work/usr" -P "$build/$part/cmake_install.cmake" >/dev/null
    done
    # In another place than it was configured for: the tree is relocatable.
    mv "$work/usr" "$work/elsewhere"
    for law in fracture_energy cyclic_joint; do
      [ -s "$work/elsewhere/share/quoin/laws/$law/LAW.md" ] || { echo "the law in words is not installed: $law"; exit 1; }
    done
    cmake -S "$source/tests/consumer/find_package" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/elsewhere" \
      -DLAWS="$*" >"$work/log" || { cat "$work/log"; exit 1; }
    cmake --build "$work/build" >>"$work/log"
    (cd "$work/build" && ctest --output-on-failure)
    pc=$(find "$work/elsewhere" -name quoin.pc)
    if command -v pkg-config >/dev/null; then
      flags=$(PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --cflags quoin)
      [ -s "$(PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --variable=symbolmap quoin)" ]
      cc -std=c99 $flags "$source/tests/consumer/host.c" -o "$work/by_pkg_config"
      "$work/by_pkg_config"
    else
      echo "pkg-config: skipped, not installed"
    fi
    if python3 -c 'import numpy' 2>/dev/null; then
      adapters=$work/elsewhere/share/quoin/adapters
      module=$(dirname "$(dirname "$(find "$work/elsewhere" -path "*/quoin/law.py")")")
      PYTHONPATH=$module:$adapters/shared:$adapters/lammps:$adapters/yade PYTHONDONTWRITEBYTECODE=1 \
        python3 -c 'import atom_joints, cube_scene, joints'
    else
      echo "adapters in Python: skipped, NumPy is not installed"
    fi
    # A Python finds the module by itself where it is installed beside it: a virtual environment, Debian's /usr/local.
    if /usr/bin/python3 -m venv --without-pip --system-site-packages "$work/venv" &&
        "$work/venv/bin/python3" -c 'import numpy'; then
      cmake -DCMAKE_INSTALL_PREFIX="$work/venv" -P "$build/plugin_api/cmake_install.cmake" >/dev/null
      (cd / && env -u PYTHONPATH "$work/venv/bin/python3" -B -c 'import quoin; print(quoin.__file__)') |
        grep "^$work/venv/lib/"
    else
      echo "virtual environment: skipped, /usr/bin/python3 has no venv or no NumPy"
    fi
    if /usr/bin/python3 -c 'import sys; sys.exit("/usr/local/lib" not in "".join(sys.path))'; then
      DESTDIR=$work/root cmake -DCMAKE_INSTALL_PREFIX=/usr/local -P "$build/plugin_api/cmake_install.cmake" >/dev/null
      folder=$(dirname "$(dirname "$(find "$work/root" -path "*/quoin/law.py")")")
      (cd / && /usr/bin/python3 -c 'import sys; print("\n".join(sys.path))') | grep -x "${folder#"$work/root"}"
    else
      echo "/usr/local: skipped, /usr/bin/python3 does not look there"
    fi
    ;;
  program)
    # Whoever has the installed program alone finds what its help names, and can run it.
    cmake --install "$build" --prefix "$work/usr" --component program >"$work/log" || { cat "$work/log"; exit 1; }
    quoin=$work/usr/bin/quoin
    for command in "" run check models path fit reproduce report ensemble sensitivity spectrum limit; do
      "$quoin" $command --help
    done >"$work/help"
    if grep -nE "(^| )(host|tests)/" "$work/help"; then
      echo "the help names files of the source tree"
      exit 1
    fi
    grep -o "$work/usr/share/[A-Za-z0-9_./]*" "$work/help" | sort -u >"$work/named"
    while read -r file; do
      [ -e "$file" ] || { echo "named in the help, not installed: $file"; exit 1; }
    done <"$work/named"
    [ "$(wc -l <"$work/named")" -ge 8 ]
    # Manual page and completions name what is installed, too.
    for file in man/man1/quoin.1 bash-completion/completions/quoin zsh/vendor-completions/_quoin \
                fish/vendor_completions.d/quoin.fish; do
      [ -s "$work/usr/share/$file" ] || { echo "not installed: share/$file"; exit 1; }
    done
    grep -q "$(echo "$work" | sed 's/-/.-/g')/usr/share/quoin/scenes/solid_wall_030.toml" "$work/usr/share/man/man1/quoin.1"
    # The reference, and every page that it leads to.
    share=$work/usr/share/quoin
    grep -o '](\.\./[^)#]*' "$share/manual/REFERENCE.md" | cut -c6- | sort -u >"$work/pages"
    while read -r page; do
      [ -s "$share/$page" ] || { echo "named in manual/REFERENCE.md, not installed: $page"; exit 1; }
    done <"$work/pages"
    [ "$(wc -l <"$work/pages")" -ge 6 ]
    for file in CHANGELOG.md CITATION.cff copyright; do
      [ -s "$work/usr/share/doc/quoin/$file" ] || { echo "not installed: share/doc/quoin/$file"; exit 1; }
    done
    "$quoin" check "$work/usr/share/quoin/scenes/solid_wall_030.toml"
    "$quoin" path "$work/usr/share/quoin/paths/couplet.toml"
    "$quoin" ensemble "$work/usr/share/quoin/studies/solid_wall_030.toml" --out "$work/out" --samples 1 --no-pictures \
      --set stage.shear.displacement=1e-6
    ;;
  subdirectory)
    cmake -S "$source/tests/consumer/subdirectory" -B "$work/build" -DQUOIN_SOURCE_DIR="$source" -DBUILD_TESTING=OFF \
      >"$work/log" || { cat "$work/log"; exit 1; }
    cmake --build "$work/build" >>"$work/log" || { cat "$work/log"; exit 1; }
    "$work/build/consumer"
    ;;
  demo)
    configure() {
      cmake -S "$source" --preset "$1" -B "$work/build" -G Ninja -DCMAKE_DISABLE_FIND_PACKAGE_GTest=$2 \
        -DCMAKE_DISABLE_FIND_PACKAGE_benchmark=$2 -DCMAKE_DISABLE_FIND_PACKAGE_Python3=$2 >"$work/log" 2>&1 ||
        { cat "$work/log"; exit 1; }
      ninja -C "$work/build" -t targets all >"$work/targets"
    }
    has() {
      grep -q "^$1: " "$work/targets"
    }
    program_alone() {
      configure demo ON
      has quoin && has fracture_energy && ! has cli_test || { echo "demo, $1: not the program alone"; exit 1; }
    }
    program_alone first
    configure release OFF
    has quoin && has cli_test && has law_benchmark || { echo "release after demo: not everything"; exit 1; }
    program_alone again
    ;;
esac
