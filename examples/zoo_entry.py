"""An entry of a leaderboard, made and checked: the clearance rule, among people who never wait."""

from pathlib import Path

from jaxwalk.cli import main

entry, board = Path("zoo/clearance"), Path("leaderboard.md")
entry.mkdir(parents=True, exist_ok=True)
(entry / "README.md").write_text("The clearance rule as it comes with jaxwalk.\n")
code = main(f"evaluate --driver clearance --episodes 2000 --out {entry}".split())
assert code == 0
code = main(f"submit {entry} --check --out {board}".split())
assert code == 0
print(board.read_text())
assert "| clearance | yes |" in board.read_text()  # it came out again, and was played on fresh scenarios
