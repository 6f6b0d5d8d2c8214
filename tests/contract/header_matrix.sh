#!/bin/sh
# The headers, each alone and the layout asserts, compile as C99..C17 and C++11..C++20 with every warning that a user may
# have on, with gcc and clang (those that are installed).
# usage: header_matrix.sh INCLUDE_DIR SOURCE_DIR
include=$1
source=$2
runs=0
for pair in gcc:g++ clang:clang++; do
  c=${pair%%:*}
  cxx=${pair##*:}
  command -v "$c" >/dev/null || { echo "skip $c: not installed"; continue; }
  for header in "$include"/quoin/*.h "$source/header_alone.c"; do
    for std in c99 c11 c17; do
      "$c" -std=$std -pedantic-errors -Wall -Wextra -Werror -Wstrict-prototypes -Wundef -fsyntax-only -x c \
        -I"$include" "$header" || { echo "FAILED $c $std $header"; exit 1; }
      runs=$((runs + 1))
    done
    command -v "$cxx" >/dev/null || continue
    for std in c++11 c++14 c++17 c++20; do
      "$cxx" -std=$std -pedantic-errors -Wall -Wextra -Werror -Wundef -Wshadow -fsyntax-only -x c++ -I"$include" \
        "$header" || { echo "FAILED $cxx $std $header"; exit 1; }
      runs=$((runs + 1))
    done
  done
done
[ $runs -gt 0 ] || exit 1
echo "$runs header compilations without a diagnostic"
