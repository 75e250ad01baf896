#!/bin/sh
# wheel_test.sh: the wheel of build/wheel in a bare Debian root, which has python3 and nothing else (root, debootstrap).
set -eu
cd "$(dirname "$0")/.."
out=build/wheel
bare=build/bare-root
root=$out/root
if [ "$(id -u)" != 0 ] || ! command -v debootstrap >/dev/null; then
  echo "not tested in a bare root: this needs root and debootstrap"
  exit 77
fi
if [ ! -e "$bare/made" ]; then
  rm -rf "$bare"
  debootstrap --variant=minbase --include=python3 "$(. /etc/os-release && echo "$VERSION_CODENAME")" "$bare"
  touch "$bare/made"
fi
rm -rf "$root" "$out/needed"
cp -a "$bare" "$root"
.venv/bin/python -m pip download --quiet --only-binary :all: --dest "$out/needed" pip "$out"/*.whl
mv "$out/needed" "$root/needed"
cp tools/wheel_commands.sh "$root/"
# programs find the libraries of the wheel by their own path, which the loader reads from /proc
mount -t proc proc "$root/proc"
trap 'umount "$root/proc"' EXIT
env -i PATH=/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin chroot "$root" sh /wheel_commands.sh
trap - EXIT
umount "$root/proc"
rm -rf "$root"
echo "the wheel works in a bare root"
