#!/bin/sh
# The laws on instruction sets that this machine does not have, bit for bit:
#   neon    beside this machine's; cross-compiled, run by qemu: g++-aarch64-linux-gnu qemu-user-static
#   avx512  beside AVX2, the very laws of BUILD_FOLDER; natively, or both sets under Bochs (minutes): bochs bochsbios
#           vgabios isolinux syslinux-common xorriso cpio; a kernel of Debian in /boot, or QUOIN_VMLINUZ=FILE. Both
#           there, because the fused multiply-add of Bochs 2.7 loses what is left of a product some 60 bits down.
# usage: tests/kernels/instruction_sets.sh neon|avx512|all [BUILD_FOLDER]
# One line for each set and law. Exit code: 0 identical, 1 different, 77 nothing could be run. Installs nothing.
set -eu
cd "$(dirname "$0")/../.."
sets=${1:-all}
build=$(cd "${2:-build/release}" && pwd)
scratch=$(mktemp -d)
bochs_pid=
trap '[ -z "$bochs_pid" ] || kill "$bochs_pid" 2>/dev/null || true; rm -rf "$scratch"' EXIT
trap 'exit 1' INT TERM
ran=0
failed=0

laws=$(cat "$build/laws.txt")
for file in instruction_sets $(printf 'laws/%s.so ' $laws); do
  [ -e "$build/$file" ] || { echo "skipped: $build/$file is not built"; exit 77; }
done

# Prints what is missing of some programs and files.
missing() {
  for need in "$@"; do
    [ -e "$need" ] || command -v "$need" >/dev/null || { echo "$need"; return; }
  done
}

neon() {
  lacks=$(missing aarch64-linux-gnu-g++ qemu-aarch64-static)
  [ -z "$lacks" ] || { echo "NEON skipped: $lacks is not installed (g++-aarch64-linux-gnu, qemu-user-static)"; return; }
  "$build/instruction_sets" write "$scratch/reference" "$build/laws" >"$scratch/written"
  if ! grep -q '^AVX[23]' "$scratch/written"; then
    echo "NEON skipped: this machine has no AVX2 to compare with"
    return
  fi
  ran=1
  cmake --preset aarch64 >/dev/null
  cmake --build --preset aarch64 --target quoin_laws >/dev/null
  aarch64-linux-gnu-g++ -std=c++20 -O2 -ffp-contract=off -I. -Iplugin_api/include -Iplugin_api/cpp tests/kernels/instruction_sets.cpp \
    -o build/aarch64/instruction_sets
  echo "beside $(cut -d, -f1 "$scratch/written" | head -n 1):"
  qemu-aarch64-static -L /usr/aarch64-linux-gnu build/aarch64/instruction_sets compare "$scratch/reference" \
    build/aarch64/laws || failed=1
}

avx512() {
  if grep -qw avx512dq /proc/cpuinfo 2>/dev/null; then
    ran=1
    "$build/instruction_sets" avx512 "$scratch/reference" "$build/laws" || failed=1
    return
  fi
  vmlinuz=${QUOIN_VMLINUZ:-$(find /boot -name "vmlinuz-*" | sort | tail -n 1)}
  isolinux=/usr/lib/ISOLINUX/isolinux.bin
  loader=/usr/lib/syslinux/modules/bios/ldlinux.c32
  roms=/usr/share/bochs
  lacks=$(missing bochs-bin xorriso cpio $isolinux $loader $roms/BIOS-bochs-latest $roms/VGABIOS-lgpl-latest \
    "${vmlinuz:-/boot/vmlinuz}")
  [ -z "$lacks" ] || { echo "AVX-512 skipped: no $lacks (the packages at the head of this script)"; return; }
  ran=1
  # An initial file system with nothing but the program as its first process, the laws and their libraries.
  root=$scratch/root
  iso=$scratch/iso
  mkdir -p "$root/lib" "$root/lib64" "$root/laws" "$iso"
  cp "$build/instruction_sets" "$root/init"
  for law in $laws; do strip -o "$root/laws/$law.so" "$build/laws/$law.so"; done
  ldd "$build/instruction_sets" "$build/laws/fracture_energy.so" | grep -o '/[^ ]*\.so[^ ]*' | grep -v "$build" | sort -u |
    while read -r library; do
      case $library in *ld-linux*) cp -L "$library" "$root/lib64" ;; *) cp -L "$library" "$root/lib" ;; esac
    done
  (cd "$root" && find . | cpio -o -H newc --quiet) >"$iso/initrd"
  cp "$vmlinuz" "$iso/linux"
  cp $isolinux $loader "$iso"
  # Bochs 2.7 gives the size of the compact save area wrongly, and Linux then leaves AVX out: no compact area.
  cat >"$iso/isolinux.cfg" <<EOF
default laws
label laws
  kernel /linux
  append initrd=/initrd console=ttyS0 quiet loglevel=1 mitigations=off tsc=reliable clearcpuid=xsavec,xsaves -- avx512 /written /laws
EOF
  xorriso -as mkisofs -quiet -o "$scratch/cd.iso" -b isolinux.bin -c boot.cat -no-emul-boot -boot-load-size 4 \
    -boot-info-table "$iso" 2>/dev/null
  cat >"$scratch/bochsrc" <<EOF
display_library: rfb, options="timeout=0"
cpu: model=corei7_skylake_x, ips=50000000
memory: guest=512, host=512
romimage: file=$roms/BIOS-bochs-latest
vgaromimage: file=$roms/VGABIOS-lgpl-latest
ata0-master: type=cdrom, path=$scratch/cd.iso, status=inserted
boot: cdrom
com1: enabled=1, mode=file, dev=$scratch/serial
log: $scratch/log
speaker: enabled=0
sound: waveoutdrv=dummy, waveindrv=dummy, midioutdrv=dummy
EOF
  echo c >"$scratch/commands"  # Debian's Bochs starts in its debugger
  bochs-bin -q -f "$scratch/bochsrc" <"$scratch/commands" >"$scratch/screen" 2>&1 &
  bochs_pid=$!
  # The first process ends, and Linux with it.
  waited=0
  until grep -aq "Attempted to kill init" "$scratch/serial" 2>/dev/null; do
    if ! kill -0 $bochs_pid 2>/dev/null || [ $waited -ge 3600 ]; then
      echo "AVX-512: Bochs did not come to the end"
      tail -n 5 "$scratch/screen" "$scratch/log" "$scratch/serial" || true
      failed=1
      return
    fi
    sleep 5
    waited=$((waited + 5))
  done
  sleep 2
  kill $bochs_pid
  bochs_pid=
  tr -d '\r' <"$scratch/serial" | grep -a '^AVX' || true
  grep -aq "Attempted to kill init! exitcode=0x00000000" "$scratch/serial" || failed=1
}

case $sets in
  neon) neon ;;
  avx512) avx512 ;;
  all) neon; avx512 ;;
  *) echo "usage: $0 neon|avx512|all [BUILD_FOLDER]" >&2; exit 2 ;;
esac
[ $failed = 0 ] || exit 1
[ $ran = 1 ] || exit 77
