"""The pages of the Python reference: which names are public, where each is defined, and a page for each package.

Names are read from the source, not imported: a page takes no JAX.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from website.repository import ROOT

SRC = ROOT / "src"
MODULES = {
    "jaxwalk": "what most programs need",
    "jaxwalk.interfaces": "what environments, views and policies are",
    "jaxwalk.rollout": "act, step, restart: episodes over time",
    "jaxwalk.sim.sim_config": "every number of a world",
    "jaxwalk.sim.person_kind": "kinds of people",
    "jaxwalk.sim.observation": "what a role observes",
    "jaxwalk.sim.features": "the parts of an observation",
    "jaxwalk.sim.reward": "reward terms",
    "jaxwalk.sim.cost": "costs beside the reward",
    "jaxwalk.maps": "maps: reading, checking, arrays",
    "jaxwalk.maps.generated": "streets from numbers",
    "jaxwalk.maps.network": "a street as plain data",
    "jaxwalk.maps.imported.importing": "streets of the real world",
    "jaxwalk.scenarios": "sources of scenarios",
    "jaxwalk.policies": "drivers, people, shields, trained policies",
    "jaxwalk.policies.host": "drivers that are not written in JAX",
    "jaxwalk.evaluation": "play, evaluate, compare, replay",
    "jaxwalk.metrics": "metrics and their statistics",
    "jaxwalk.recipes": "complete trainings under a name",
    "jaxwalk.runs.entry": "trainings from Python",
    "jaxwalk.learning.config": "every setting of the learner",
    "jaxwalk.learning.mappo": "the learner",
    "jaxwalk.adapters.gymnasium": "the street as a Gymnasium environment",
    "jaxwalk.adapters.stable_baselines3": "many streets as Stable-Baselines3's vector environment",
    "jaxwalk.adapters.pettingzoo": "the street as a PettingZoo environment",
    "jaxwalk.adapters.jaxmarl": "the street as a JaxMARL environment",
    "jaxwalk.viewer": "pictures, animations, pages of episodes",
    "jaxwalk.report": "reports from results",
    "jaxwalk.raters": "pages for raters, and what their answers say",
    "jaxwalk.testing": "checks of parts of your own",
}
"""The modules that have a page, in the order of the list, each in a few words."""
NOT_FOR_IMPORT = ("jaxwalk.cli",)
"""Packages whose ``__all__`` is for jaxwalk alone."""
FOLDER = "reference"


@dataclass(frozen=True)
class PublicName:
    """A name that a module offers."""

    name: str
    module: str
    """The module that offers it."""
    home: str
    """The module that defines it."""

    @property
    def path(self) -> str:
        """Where it is defined, with its name."""
        return f"{self.home}.{self.name}"


@lru_cache(maxsize=32)  # all trees together take 100 MB
def tree_of(module: str) -> ast.Module:
    """Return the syntax tree of a module."""
    return ast.parse(file_of(module).read_text(encoding="utf-8"))


def file_of(module: str) -> Path:
    """Return the file of a module."""
    path = SRC.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def packages_with_names() -> list[str]:
    """Return all packages and modules that list their public names in ``__all__``."""
    files = sorted((SRC / "jaxwalk").rglob("*.py"))
    modules = (".".join(file.relative_to(SRC).with_suffix("").parts).removesuffix(".__init__") for file in files)
    return [each for each in modules if not each.startswith(NOT_FOR_IMPORT) and _listed(tree_of(each)) is not None]


def public_names(module: str) -> list[PublicName]:
    """Return the public names of a module: those of ``__all__``, else all that it defines and describes."""
    listed = _listed(tree_of(module))
    names = _described(tree_of(module)) if listed is None else [name for name in listed if name != "__version__"]
    return [PublicName(name, module, _home(module, name)) for name in names]


def _listed(tree: ast.Module) -> list[str] | None:
    """Return ``__all__``, whose names may be those of the table ``_HOMES``; None if there is none."""
    value = _assigned(tree).get("__all__")
    if value is None:
        return None
    if isinstance(value, ast.List) and all(isinstance(item, ast.Constant) for item in value.elts):
        return list(ast.literal_eval(value))
    return sorted(_homes(tree))


def _homes(tree: ast.Module) -> Mapping[str, str]:
    """Return the table of a package whose names are imported when they are first used; {} for another one."""
    table = _assigned(tree).get("_HOMES")
    return {} if table is None else ast.literal_eval(table)


def _assigned(tree: ast.Module) -> dict[str, ast.expr]:
    """Return what a module assigns to names at its top."""
    found = {}
    for node in tree.body:
        if not isinstance(node, ast.Assign | ast.AnnAssign):
            continue
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        found |= {target.id: node.value for target in targets if isinstance(target, ast.Name) and node.value}
    return found


def _described(tree: ast.Module) -> list[str]:
    """Return the names that a module defines and describes, in their order."""
    definitions = (ast.ClassDef, ast.FunctionDef)
    found = []
    for node, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if isinstance(node, definitions):
            found.append(node.name)
        elif isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            found += _assigned(ast.Module([node], []))
    return [name for name in found if not name.startswith("_")]


def _home(module: str, name: str) -> str:
    """Return the module that defines a name which ``module`` offers."""
    tree = tree_of(module)
    if name in _homes(tree):
        return _home(f"{module}.{_homes(tree)[name]}", name)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and name in [alias.name for alias in node.names]:
            return _home(node.module, name)
    return module


def file_name(module: str) -> str:
    """Return the name of a module's page in the folder of the reference."""
    return f"{module.removeprefix('jaxwalk.')}.md"


def reference_pages() -> Iterator[tuple[str, str]]:
    """Yield each page of the reference: its path in the site, and its text.

    A name that several modules offer is described once; the others' pages lead there.
    """
    shown: dict[str, str] = {}
    yield f"{FOLDER}/index.md", _index()
    for module, about in MODULES.items():
        names = public_names(module)
        own = [each for each in names if each.path not in shown]
        links = [f"[`{each.name}`]({shown[each.path]}#{each.path})" for each in names if each.path in shown]
        shown |= {each.path: file_name(module) for each in own}
        begin = (ast.get_docstring(tree_of(module)) or about).replace("``", "`")
        more = f"Also here: {', '.join(links)}.\n" if links else ""
        blocks = map(_block, own)
        yield f"{FOLDER}/{file_name(module)}", "\n".join([f"# {module}\n", f"{begin}\n", more, *blocks])


def _block(name: PublicName) -> str:
    """Return the Markdown that describes a name; of names that are assigned several at once, the tool finds none."""
    tree = tree_of(name.home)
    for node, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Tuple):
            continue
        if name.name in [ast.unparse(target) for target in node.targets[0].elts]:
            text = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else ""
            return f"## `{name.name}` {{ #{name.path} }}\n\n{text}\n"
    return f"::: {name.path}\n"


def _index() -> str:
    rows = (f"| [`{module}`]({file_name(module)}) | {about} |" for module, about in MODULES.items())
    head = (
        "# Python reference\n",
        "For people who write Python with jaxwalk: every public name, from the docstrings of the code. What isn't",
        "listed here may change without notice.\n",
        "| module | what it is for |",
        "| --- | --- |",
    )
    return "\n".join([*head, *rows, ""])
