#!/bin/sh
# usage: expect_clause.sh CHECKER LIBRARY CLAUSE WHAT; an empty clause: the checker must pass the law.
found=$("$1" "$2")
code=$?
failed=$(printf '%s\n' "$found" | sed -n 's/^  FAILED  \(C[0-9.]*\).*/\1/p' | tr '\n' ' ')
echo "$4: exit $code, broken clauses: ${failed:-none}"
if [ -z "$3" ]; then
  [ $code -eq 0 ] && [ -z "$failed" ] && exit 0
else
  case " $failed" in *" $3 "*) [ $code -eq 1 ] && exit 0 ;; esac
fi
printf '%s\n' "$found"
exit 1
