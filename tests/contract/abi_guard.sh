#!/bin/sh
# usage: abi_guard.sh SOURCE_DIR WORK_DIR [--update]: the types that cross the boundary, against the baseline in abi/.
# The template law is compiled with debug information and read by abidw. Exit 77: skipped.
set -e
here=$(cd "$(dirname "$0")" && pwd)
for tool in abidw abidiff gcc; do
  command -v $tool >/dev/null || { echo "skipped: $tool is not installed (package abigail-tools)"; exit 77; }
done
mkdir -p "$2"
cd "$1"
gcc -std=c99 -g -Og -fPIC -shared -Iplugin_api/include -Wl,--version-script=plugin_api/quoin.map \
  plugin_api/template/template_law.c -lm -o "$2/template_law_abi.so"
abidw --no-corpus-path --no-comp-dir-path --no-show-locs --headers-dir plugin_api/include --drop-private-types \
  "$2/template_law_abi.so" >"$2/quoin_v1.1.abi"
if [ "$3" = --update ]; then
  cp "$2/quoin_v1.1.abi" "$here/abi/quoin_v1.1.abi"
  echo "new baseline: $here/abi/quoin_v1.1.abi"
  exit 0
fi
abidiff "$here/abi/quoin_v1.1.abi" "$2/quoin_v1.1.abi" && echo "no difference to the baseline of ABI version 1.1"
# Against the versions before: nothing but data members behind those that were there.
for old in "$here"/abi/quoin_v1.0.abi; do
  changes=$(abidiff "$old" "$2/quoin_v1.1.abi") || [ $(($? & 8)) -eq 0 ] || { echo "$changes"; exit 1; }
  if echo "$changes" | grep -E 'deletion|offset changed|[1-9][0-9]* Removed|type of .quoin.* changed from'; then
    echo "more than appended since $(basename "$old")"
    exit 1
  fi
  echo "$changes" | grep -A1 'data member insertion'
done
