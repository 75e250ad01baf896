#!/bin/sh
# browser.sh: Chromium for the tests of pages in a browser. The exit status is 77 where it cannot be installed.
"$(dirname "$0")/install-dependencies.sh" browser || exit 77
