"""An entry of a leaderboard, made and checked: the clearance rule, among people who never wait."""

from pathlib import Path

from jaxwalk.cli import main

entry = Path("zoo/clearance")
entry.mkdir(parents=True)
(entry / "README.md").write_text("The clearance rule as it comes with jaxwalk.\n")
main(f"evaluate --driver clearance --episodes 2000 --out {entry}".split())
main(f"submit {entry} --check".split())
