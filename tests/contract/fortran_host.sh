#!/bin/sh
# usage: fortran_host.sh SOURCE_DIR WORK_DIR LAW...: the Fortran host is built and driven with every law.
command -v gfortran >/dev/null || { echo "skipped: gfortran is not installed"; exit 77; }
source=$1
work=$2
shift 2
gfortran -std=f2018 -Wall -Wextra -Werror -O2 -J"$work" "$source/quoin.f90" "$source/vuinter_like.f90" -ldl \
  -o "$work/vuinter_like" || exit 1
for law in "$@"; do
  "$work/vuinter_like" "$law" || exit 1
done
