#!/bin/sh
# debian_source.sh FOLDER PACKAGE [BINARY...]: Debian's source package in FOLDER/src, and what binary packages hold in
# FOLDER/deb; nothing is installed. The machine's own package sources are asked, in a private view of apt, for source
# packages too. Exit code 1 where they do not have it, with the reason in the last line.
set -u
folder=$1 package=$2
shift 2
apt=$folder/apt
mkdir -p "$apt/parts" "$apt/lists/partial" "$apt/cache/archives/partial" "$folder/src" "$folder/deb"
for list in /etc/apt/sources.list.d/*.sources; do
  [ -f "$list" ] && sed 's/^Types: *deb *$/Types: deb deb-src/' "$list" >"$apt/parts/$(basename "$list")"
done
for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
  [ -f "$list" ] && sed -n 's/^deb /&/p; s/^deb /deb-src /p' "$list" >"$apt/parts/$(basename "$list")"
done
cat >"$apt/conf" <<END
Dir::Etc::SourceList "/dev/null";
Dir::Etc::SourceParts "$apt/parts";
Dir::State::Lists "$apt/lists";
Dir::Cache "$apt/cache";
APT::Sandbox::User "";
END
export APT_CONFIG=$apt/conf

apt-get -q update >"$folder/apt.log" 2>&1
(cd "$folder/src" && apt-get -q source "$package" >>"$folder/apt.log" 2>&1) || {
  echo "no source package $package in this machine's package sources ($folder/apt.log)"
  exit 1
}
[ $# = 0 ] || (cd "$folder/deb" && apt-get -q download "$@" >>"$folder/apt.log" 2>&1 &&
  for binary in *.deb; do dpkg-deb -x "$binary" . || exit 1; done) || {
  echo "no packages $* ($folder/apt.log)"
  exit 1
}
