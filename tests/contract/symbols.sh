#!/bin/sh
# usage: symbols.sh LIBRARY...: every library exports exactly the symbols listed in abi/symbols.txt.
expected=$(grep -v '^#' "$(dirname "$0")/abi/symbols.txt")
for library in "$@"; do
  found=$(nm -D --defined-only "$library" | awk '{print $NF}' | sort)
  if [ "$found" != "$expected" ]; then
    echo "$library exports:"
    echo "$found"
    exit 1
  fi
  echo "$(basename "$library"): $found"
done
