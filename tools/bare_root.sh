#!/bin/sh
# bare_root.sh PACKAGES NEEDED COMMANDS: runs the script COMMANDS in a fresh Debian root that has the PACKAGES (separated
# by commas) and the folder NEEDED as /needed. The exit status is 77 without root or debootstrap.
set -eu
packages=$1 needed=$2 commands=$3
if [ "$(id -u)" != 0 ] || ! command -v debootstrap >/dev/null; then
  echo "not tested in a bare root: this needs root and debootstrap"
  exit 77
fi
bare=build/bare-root/$(echo "$packages" | tr , -)
root=build/bare-root/in-use-$$
if [ ! -e "$bare/made" ]; then
  rm -rf "$bare"
  mkdir -p build/bare-root
  debootstrap --variant=minbase --include="$packages" "$(. /etc/os-release && echo "$VERSION_CODENAME")" "$bare"
  touch "$bare/made"
fi
cp -a "$bare" "$root"
cp -a "$needed" "$root/needed"
cp "$commands" "$root/commands.sh"
# programs find the libraries of the wheel by their own path, which the loader reads from /proc
mount -t proc proc "$root/proc"
# tests open terminals, and servers on this machine
mount -t devpts -o ptmxmode=0666 devpts "$root/dev/pts"
ln -sf pts/ptmx "$root/dev/ptmx"
echo "127.0.0.1 localhost" >"$root/etc/hosts"
trap 'umount "$root/proc" "$root/dev/pts" && rm -rf "$root"' EXIT
env -i PATH=/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin chroot "$root" sh /commands.sh
