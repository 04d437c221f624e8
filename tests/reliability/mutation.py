"""Do the tests bite? Small mistakes are put into the definitions, one at a time; each should fail a test of its module.

    make mutants                                            # all of them: some six hours on two slow cores
    python tests/reliability/mutation.py losses --sample 50
    python tests/reliability/mutation.py losses --out survivors.json, then --again survivors.json: are they caught now?

Works in copies of src/ and tests/. Cosmic Ray (``pip install cosmic-ray``) makes the mistakes: another operator, a
comparison that includes or leaves out its limit, a number plus one, a condition turned round. What annotations alone
would show is left out, since it changes nothing that runs.
"""

from __future__ import annotations

import argparse
import ast
import json
import multiprocessing
import os
import random
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from difflib import unified_diff
from pathlib import Path
from queue import SimpleQueue

import jaxtyping
import pytest
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from hypothesis import Phase, settings
from rich.console import Console
from rich.progress import track

ROOT = Path(__file__).resolve().parents[2]
GROUPS = {
    "events": (["sim/events.py"], ["tests/sim/test_events.py", "tests/metrics/test_encounters.py"]),
    "rewards": (["sim/reward.py"], ["tests/sim/test_reward.py", "tests/sim/test_events.py"]),
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
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(
    ["__main__", "hypothesis.strategies", "jax.numpy", "jaxtyping", "beartype.claw", "scipy.stats"]
)
"""Each mutant's tests run in a process of their own, forked off one in which this was imported (jaxwalk was not)."""


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

    def visit_arguments(self, node: ast.arguments) -> ast.arguments:
        self.generic_visit(node)  # whether some must be named says nothing of what is computed
        node.args = [*node.posonlyargs, *node.args, *node.kwonlyargs]
        node.defaults = [*node.defaults, *filter(None, node.kw_defaults)]
        node.posonlyargs, node.kwonlyargs, node.kw_defaults = [], [], []
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


def _run(copy: Path, tests: list[str]) -> None:
    """In a process of its own: exits with what pytest says."""
    os.chdir(copy)
    sys.path.insert(0, str(copy / "src"))
    os.environ["PYTHONPATH"] = str(copy / "src")
    sys.dont_write_bytecode = False  # what the mutant doesn't change is compiled once
    jaxtyping.config.update("jaxtyping_disable", True)  # shapes are checked in `make test`: that would only kill more
    settings.register_profile("bites", phases=[Phase.explicit, Phase.reuse, Phase.generate])  # one failure is enough
    settings.load_profile("bites")
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    known = "ignore:Module already imported:pytest.PytestAssertRewriteWarning"
    sys.exit(pytest.main(["-x", "-q", "-p", "no:xdist", "-W", known, *tests]))


def _passes(copy: Path, group: str, module: str = "") -> bool:
    """Whether the tests of a group pass in a copy."""
    process = FORKS.Process(target=_run, args=(copy, _tests(group, module)))
    process.start()
    process.join(SECONDS)
    process.kill()
    process.join()
    return process.exitcode == 0


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
    first = folder / "0"
    for part in ("src", "tests"):
        shutil.copytree(ROOT / part, first / part)
    shutil.copy(ROOT / "pyproject.toml", first)
    for group in groups:
        if not _passes(first, group):
            sys.exit(f"{' '.join(GROUPS[group][1])}: fails without any mutant; mend that first")
    copies: SimpleQueue[Path] = SimpleQueue()
    copies.put(first)
    for k in range(1, number):
        copies.put(shutil.copytree(first, folder / str(k)))
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
    parser.add_argument("--again", type=Path, metavar="FILE", help="try those that survived, by an --out of before")
    options = parser.parse_args()
    groups = options.groups or list(GROUPS)
    if unknown := set(groups) - set(GROUPS):
        parser.error(f"no such group: {', '.join(unknown)}; there are {', '.join(GROUPS)}")
    mutants = [mutant for group in groups for path in _files(group) for mutant in _mutants(group, path)]
    if options.again:
        survived = {(one["module"], one["diff"]) for one in json.loads(options.again.read_text(encoding="utf-8"))}
        mutants = [mutant for mutant in mutants if (mutant.module, mutant.diff) in survived]
    random.Random(options.seed).shuffle(mutants)
    mutants = mutants[: options.sample]
    alive: list[Mutant] = []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.jobs) as pool:
        copies = _copies(Path(folder), options.jobs, groups)
        tried = zip(mutants, pool.map(lambda mutant: _survives(mutant, copies), mutants), strict=True)
        bar = track(tried, "mutants", total=len(mutants), console=Console(stderr=True))
        for number, (mutant, survives) in enumerate(bar, 1):
            if survives:
                alive.append(mutant)
                print(f"survives ({number} of {len(mutants)} tried): {mutant.module}\n{mutant.diff}\n", flush=True)
    _report(mutants, alive)
    if options.out:
        document = [{"module": mutant.module, "diff": mutant.diff} for mutant in alive]
        options.out.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
