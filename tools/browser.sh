#!/bin/sh
# browser.sh: Chromium and its driver for the tests of pages in a browser, from Debian. The exit status is 77 where they
# cannot be installed.
set -u
there() {
  command -v chromium >/dev/null && command -v chromedriver >/dev/null
}
if ! there; then
  command -v apt-get >/dev/null && [ "$(id -u)" = 0 ] || {
    echo "no root here, left out; as root: apt-get install chromium chromium-driver"
    exit 77
  }
  apt-get update -q
  DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends chromium chromium-driver
fi
there || {
  echo "no Chromium here, left out"
  exit 77
}
echo "there"
