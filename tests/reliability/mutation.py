"""Do the tests bite? Small mistakes are put into the definitions, one at a time; each should fail a test of its module.

    make mutants                                            # all of them: up to two hours on two cores
    python tests/reliability/mutation.py losses --sample 50

Works in copies of src/ and tests/. Cosmic Ray (``pip install cosmic-ray``) makes the mistakes: another operator, a
comparison that includes or leaves out its limit, a number plus one, a condition turned round. What annotations alone
would show is left out, since it changes nothing that runs.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from difflib import unified_diff
from pathlib import Path
from queue import SimpleQueue

from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from rich.console import Console
from rich.progress import track

ROOT = Path(__file__).resolve().parents[2]
GROUPS = {
    "events": (["sim/events.py"], ["tests/sim/test_events.py"]),
    "rewards": (["sim/reward.py"], ["tests/sim/test_events.py"]),
    "advantages": (["learning/advantages.py"], ["tests/learning/test_advantages.py"]),
    "losses": (["learning/losses.py"], ["tests/learning/test_losses.py", "tests/learning/test_mappo.py"]),
    "metrics": (["metrics"], ["tests/metrics"]),
}
"""Modules below src/jaxwalk (or folders of them), and the tests (or folders of them) that should notice."""
SLOW = ("test_properties.py", "test_mappo.py")
"""Tests that come last: most mutants never meet them."""

BINARY = "Add_Sub Sub_Add Mul_Div Div_Mul Pow_Mul FloorDiv_Div Mod_Div BitAnd_BitOr BitOr_BitAnd BitXor_BitAnd"
COMPARISON = "Lt_LtE LtE_Lt Gt_GtE GtE_Gt Eq_NotEq NotEq_Eq Is_IsNot IsNot_Is"
OPERATORS = [
    *(f"ReplaceBinaryOperator_{pair}" for pair in BINARY.split()),
    *(f"ReplaceComparisonOperator_{pair}" for pair in COMPARISON.split()),
    *("ReplaceUnaryOperator_USub_UAdd", "ReplaceUnaryOperator_Delete_Invert", "ReplaceUnaryOperator_Delete_Not"),
    *("ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "AddNot"),
    "NumberReplacer",
]
SECONDS = 300.0
"""A mutant whose tests take longer is killed: it may never end."""


@dataclass(frozen=True)
class Mutant:
    """One mistake in one file."""

    group: str
    module: str
    code: str
    """Of the whole file, mistaken."""
    diff: str


class _WithoutAnnotations(ast.NodeTransformer):
    def visit_arg(self, node: ast.arg) -> ast.arg:
        node.annotation = None
        return node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AnnAssign:
        self.generic_visit(node)
        node.annotation = ast.Constant(None)
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        self.generic_visit(node)
        node.returns = None
        return node


def _meaning(code: str) -> str:
    """What the code does, the same whatever its annotations; "" if it can't run."""
    try:
        return ast.dump(_WithoutAnnotations().visit(ast.parse(code)))
    except SyntaxError:
        return ""


def _mutants(group: str, path: Path) -> Iterator[Mutant]:
    code, name = path.read_text(encoding="utf-8"), str(path.relative_to(ROOT))
    for operator in OPERATORS:
        make = get_operator(f"core/{operator}")()
        occurrence, step = 0, 2 if operator == "NumberReplacer" else 1  # of a number plus and minus one, the former
        while (wrong := mutate_code(code, make, occurrence)) is not None:
            occurrence += step
            if _meaning(wrong) not in ("", _meaning(code)):
                lines = unified_diff(code.splitlines(), wrong.splitlines(), name, name, n=0, lineterm="")
                yield Mutant(group, name, wrong, "\n".join(list(lines)[2:]))


def _files(group: str) -> list[Path]:
    places = [ROOT / "src/jaxwalk" / place for place in GROUPS[group][0]]
    return [file for place in places for file in (sorted(place.glob("*.py")) if place.is_dir() else [place])]


def _tests(group: str, module: str) -> list[str]:
    """The files of tests, that of the same name first."""
    places = [ROOT / place for place in GROUPS[group][1]]
    files = [file for place in places for file in (place.glob("test_*.py") if place.is_dir() else [place])]
    own = f"test_{Path(module).name}"
    files.sort(key=lambda file: (file.name != own, file.name in SLOW, file))
    return [str(file.relative_to(ROOT)) for file in files]


def _passes(copy: Path, group: str, module: str = "") -> bool:
    """Whether the tests of a group pass in a copy."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:xdist", *_tests(group, module)]
    paths = {"PYTHONPATH": str(copy / "src"), "PYTHONDONTWRITEBYTECODE": "1"}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    try:
        return subprocess.run(command, cwd=copy, env=os.environ | paths, timeout=SECONDS, **quiet).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def _survives(mutant: Mutant, copies: SimpleQueue[Path]) -> bool:
    copy = copies.get()
    file = copy / mutant.module
    right = file.read_text(encoding="utf-8")
    try:
        file.write_text(mutant.code, encoding="utf-8")
        return _passes(copy, mutant.group, mutant.module)
    finally:
        file.write_text(right, encoding="utf-8")
        copies.put(copy)


def _copies(folder: Path, number: int, groups: list[str]) -> SimpleQueue[Path]:
    """Copies in which the tests pass, with what they compile kept."""
    copies: SimpleQueue[Path] = SimpleQueue()
    for k in range(number):
        copy = folder / str(k)
        for part in ("src", "tests"):
            shutil.copytree(ROOT / part, copy / part, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", copy)
        if k:
            shutil.copytree(folder / "0" / ".pytest_cache", copy / ".pytest_cache")
        for group in groups if k == 0 else []:
            if not _passes(copy, group):
                sys.exit(f"{' '.join(GROUPS[group][1])}: fails without any mutant; mend that first")
        copies.put(copy)
    return copies


def _report(mutants: list[Mutant], alive: list[Mutant]) -> None:
    made, left = Counter(mutant.module for mutant in mutants), Counter(mutant.module for mutant in alive)
    for module in sorted(made):
        killed = made[module] - left[module]
        print(f"{module}: {killed} of {made[module]} killed ({killed / made[module]:.0%})")
    killed = len(mutants) - len(alive)
    print(f"killed {killed} of {len(mutants)} mutants ({killed / len(mutants):.1%})")


def main() -> None:
    """Read the command line, make the mutants, say which survive."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("groups", nargs="*", help=f"of {', '.join(GROUPS)}; all by default")
    parser.add_argument("--sample", type=int, help="try only so many, drawn by chance")
    parser.add_argument("--seed", type=int, default=0, help="of that chance")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="so many at a time")
    parser.add_argument("--out", type=Path, help="write the survivors there too, as JSON")
    options = parser.parse_args()
    groups = options.groups or list(GROUPS)
    if unknown := set(groups) - set(GROUPS):
        parser.error(f"no such group: {', '.join(unknown)}; there are {', '.join(GROUPS)}")
    mutants = [mutant for group in groups for path in _files(group) for mutant in _mutants(group, path)]
    random.Random(options.seed).shuffle(mutants)
    mutants = mutants[: options.sample]
    alive: list[Mutant] = []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.jobs) as pool:
        copies = _copies(Path(folder), options.jobs, groups)
        tried = zip(mutants, pool.map(lambda mutant: _survives(mutant, copies), mutants), strict=True)
        for mutant, survives in track(tried, "mutants", total=len(mutants), console=Console(stderr=True)):
            if survives:
                alive.append(mutant)
                print(f"survives: {mutant.module}\n{mutant.diff}\n", flush=True)
    _report(mutants, alive)
    if options.out:
        document = [{"module": mutant.module, "diff": mutant.diff} for mutant in alive]
        options.out.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
