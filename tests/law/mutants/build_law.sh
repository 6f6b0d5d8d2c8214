#!/bin/sh
# build_law.sh CONTACT_MODELS_FOLDER LAW OUT.so: a law from a (changed) copy of contact_models, for the
# baseline instruction set only: a quarter of the build time, the same equations.
set -eu
models=$1
law=$2
out=$3
api=$(cd "$(dirname "$0")/../../../plugin_api" && pwd)
mkdir -p "$(dirname "$out")"
# shellcheck disable=SC2086  # the compiler may carry a launcher
${CXX:-c++} -std=c++20 -O1 -fPIC -shared -ffp-contract=off -fvisibility=hidden -fno-gnu-unique -DHWY_COMPILE_ONLY_STATIC \
  -DHWY_SHARED_DEFINE -DQUOIN_LAW_VERSION='"mutant"' -I"$models" -I"$api/include" \
  "$models/$law/kernel.cpp" "$models/$law/plugin.cpp" "$models/shim/properties.cpp" \
  -Wl,--version-script="$api/quoin.map" -o "$out" -lhwy
