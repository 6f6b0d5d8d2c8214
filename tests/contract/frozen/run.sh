#!/bin/sh
# usage: run.sh HOST CHECKER: the law that was compiled against ABI 1.0 once and for all is loaded by today's host and
# checker. Its bytes never change; when this fails, today's code broke the ABI.
cd "$(dirname "$0")" || exit 1
sha256sum -c template_law_v1.so.sha256 || exit 1
[ "$(uname -m)" = x86_64 ] || { echo "skipped: the frozen binary is x86-64"; exit 77; }
found=$("$1" ./template_law_v1.so normal_stiffness=4e10 shear_stiffness=2e10) || exit 1
echo "$found"
[ "$(echo "$found" | tail -1)" = "d_n 3.0 um, d_s 1.0 um: sigma 120000 Pa, tau_s 20000 Pa" ] || exit 1
"$2" ./template_law_v1.so
