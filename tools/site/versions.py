"""versions.py SITE: list the versions in SITE for their selector; SITE/index.html leads to the newest one."""

import json
import re
import sys
from pathlib import Path

site = Path(sys.argv[1])
folders = [folder.name for folder in site.iterdir() if re.fullmatch(r"\d+\.\d+\.\d+", folder.name)]
versions = sorted(folders, key=lambda name: [int(part) for part in name.split(".")], reverse=True)
if not versions:
    sys.exit(f"{site}: expected a folder with the name of a version")
(site / "versions.json").write_text(
    json.dumps([{"version": v, "title": v, "aliases": []} for v in versions]) + "\n"
)
newest = f"{versions[0]}/"
(site / "index.html").write_text(
    f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>asperity</title>\n'
    f'<meta http-equiv="refresh" content="0; url={newest}"><a href="{newest}">{versions[0]}</a></html>\n'
)
