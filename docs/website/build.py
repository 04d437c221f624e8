"""Builds the site into build/site (`make docs`): assembles its pages, lets zensical render them, checks the result."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from website.assemble import assemble
from website.built_site import faults
from website.repository import ROOT
from website.search_index import shrink

PAGES, SITE = ROOT / "build" / "pages", ROOT / "build" / "site"


def main() -> int:
    """Build the site; print what is wrong with it and return 1, or where it is and return 0."""
    assemble(PAGES)
    command = [sys.executable, "-m", "zensical", "build", "--clean", "--strict"]
    built = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    if built.returncode:
        print(built.stdout, built.stderr, sep="\n", file=sys.stderr)
        return 1
    shrink(SITE)
    found = faults(SITE)
    print(*found[:50], sep="\n", end="\n" if found else "", file=sys.stderr)
    print(f"{len(found)} faults" if found else f"Open {(SITE / 'index.html').relative_to(ROOT)}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
