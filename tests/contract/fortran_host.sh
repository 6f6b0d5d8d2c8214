#!/bin/sh
# usage: fortran_host.sh PROJECT_DIR WORK_DIR LAW...: the Fortran shim for Abaqus/Explicit is built with its host and
# driven with every law, those with vector states to be refused; then each fault must end it with a message that names it.
command -v gfortran >/dev/null || { echo "skipped: gfortran is not installed"; exit 77; }
project=$1
work=$2
shift 2
mkdir -p "$work"
# The interfaces pass much that a law does not look at; curves are compared bit for bit.
gfortran -std=f2018 -Wall -Wextra -Werror -Wno-unused-dummy-argument -Wno-compare-reals -O2 $FFLAGS -J"$work" \
  "$project/plugin_api/adapters/abaqus/quoin_abaqus.f90" "$project/tests/adapters/abaqus_host.f90" -ldl \
  -o "$work/abaqus_host" || exit 1
for law in "$@"; do
  QUOIN_LAW_PATH=$(dirname "$law") "$work/abaqus_host" "$(basename "$law" .so)" >"$work/law.txt" 2>&1
  ended=$?
  cat "$work/law.txt"
  if grep -q "to be refused: vector state" "$work/law.txt"; then
    [ $ended != 0 ] && grep -q "a state is a vector, which the code does not turn" "$work/law.txt" || exit 1
  else
    [ $ended = 0 ] || exit 1
  fi
done

QUOIN_LAW_PATH=/nowhere:$(dirname "$1")
export QUOIN_LAW_PATH
while IFS=: read -r fault message; do
  if "$work/abaqus_host" "fault-$fault" >"$work/fault.txt" 2>&1; then
    echo "fault-$fault: went on"
    exit 1
  fi
  grep -q "$message" "$work/fault.txt" || { echo "fault-$fault: no message \"$message\" in"; cat "$work/fault.txt"; exit 1; }
done <<'FAULTS'
law:no_such_law: no law; set QUOIN_LAW_PATH
initial-state:no initial state wet; the law has bonded dry
property:normal_stiffness = -5
too-many-properties:more properties than the law has
state-variables:give it 1 state variables, not 0
not-a-number:1 points have displacements or states that are not finite
FAULTS
