#!/bin/sh
# usage: expect_refusal.sh CHECKER LIBRARY SETTING ALLOWED: a value of the user that the law does not allow is his fault,
# refused before any check.
message=$("$1" "$2" --property "$3" 2>&1 >/dev/null)
code=$?
checked=$("$1" "$2" --property "$3" 2>/dev/null)
echo "exit $code: $message"
[ $code -eq 2 ] && [ -z "$checked" ] || exit 1
case $message in "--property $3: law "*" allows $4; give one, or leave the property out") exit 0 ;; esac
exit 1
