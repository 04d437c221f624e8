"""Files to share a policy: one safetensors file that includes its results, and a model card beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jaxwalk.evaluation import evaluate_grid
from jaxwalk.evaluation.document_parts import Interval, StreetOrigin
from jaxwalk.policies import POPULATIONS, SHIPPED, load_policy, read_metadata, save_policy
from jaxwalk.policies.mixture_names import mixture_of
from jaxwalk.report.table import shown
from jaxwalk.runs.contestants import ANYWHERE, contestant, world_of
from jaxwalk.runs.folder import Run
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.suites import Where
from jaxwalk.wording import counted, first_of
from jaxwalk.writing import current, together, write_whole

Results = dict[str, Any]

FIGURES = {
    "goal %": "goal_rate", "collision %": "collision_rate", "timeout %": "timeout_rate",
    "time to goal [s]": "mean_time_to_goal", "delay [s]": "mean_delay",
}  # fmt: skip
"""The columns of a card's results, and the numbers of a cell's headline that stand there."""


@dataclass(frozen=True)
class Judging:
    """How a driver is evaluated for its card."""

    populations: Sequence[str] = ("always-go",)
    """Names of populations, as `contestant` takes them."""
    episodes: int = 2000
    seed: int = 0
    where: Where = ANYWHERE
    """Without maps: those that the run folder keeps."""


def share(
    folder: Path, out: Path, judging: Judging, *, progress: Callable[[str, str, int, int], None] | None = None
) -> Path:
    """Write the policy file of a run folder with the driver's results among people; return the card's path.

    Raises RunError if the run has no policy yet, ContestantError for an unknown population, Stopped if a policy fails.
    """
    run, here = Run.open(folder), str(folder.resolve())  # the whole path can't be a shipped policy's name
    street = world_of([here], judging.where)
    driver = {str(folder): contestant(street, "driver", here)}
    people = {_label(name): contestant(street, "pedestrian", name) for name in judging.populations}
    about = {"maps": list(run.experiment.maps), "single_agent": run.experiment.single_agent} | read_metadata(run.policy)
    actors = {role: load_policy(run.policy, role).actor for role in about.pop("roles")}
    source = Drawn(street, judging.seed, judging.episodes)
    found, _ = evaluate_grid(street, driver, people, source, progress=progress)
    about["results"] = {
        "scenarios": found.scenarios.as_dict(),
        "where": StreetOrigin.of(street).in_words(),
        "jaywalk_multiplier": found.cells[0].jaywalk_multiplier,
        "among": {cell.pedestrians: cell.headline() for cell in found.cells},
    }
    out.parent.mkdir(parents=True, exist_ok=True)
    card = out.with_suffix(".md")
    with together():
        save_policy(out, actors, about)
        write_whole(card, model_card(current(out), name=out.stem))
    return card


def _label(population: str) -> str:
    """Return a population's name for readers elsewhere: the path of a run folder means nothing there."""
    mixed = mixture_of("pedestrian", population)
    if mixed:
        return "+".join(f"{_label(kind)}:{share:g}" for kind, share in mixed.items())
    if population in (*POPULATIONS, *SHIPPED["pedestrian"]) or not Path(population).is_dir():
        return Path(population).name
    experiment = Run.open(population).experiment
    return f"learned ({experiment.recipe}, training seed {experiment.seed})"


def model_card(file: Path, *, name: str) -> str:
    """Return the model card of a shared policy as Markdown; everything below its name comes from the file itself."""
    about = read_metadata(file)
    who = "A car trained alone, among pedestrians who always go" if about["single_agent"] else "Car and pedestrians"
    maps, versions = first_of(about["maps"], "map"), ", ".join(f"{name} {x}" for name, x in about["versions"].items())
    lines = [
        f"# {name}",
        "",
        f"{who}: recipe `{about['recipe']}`, training seed {about['seed']}, {counted(about['updates'], 'update')}, "
        f"{counted(about['steps'], 'environment step')}, maps {maps}.",
        "",
        *(
            ["Scenarios that a search had found were mixed into its episodes.", ""]
            if about.get("archive_hashes")
            else []
        ),
        f"Made at commit {about['commit'] or 'unknown'} on {about['hardware']}, with {versions}.",
        "",
        "| role | reads | kind | layers | decision stands for |",
        "| --- | --- | --- | --- | --- |",
        *(_role_row(role, network) for role, network in about["roles"].items()),
        "",
        *_result_lines(about["results"]),
        "",
        "What it knows: one car, people who walk shortest ways and sometimes jaywalk. It has met no other cars, no",
        "lights and no weather, and says nothing about any real vehicle.",
        "",
    ]
    return "\n".join(lines)


def _role_row(role: str, network: dict[str, Any]) -> str:
    layers = "-".join(map(str, network["sizes"]))
    return f"| {role} | `{network['observes']}` | {network['kind']} | {layers} | {counted(network['hold'], 'step')} |"


def _result_lines(results: Results) -> list[str]:
    chosen = results["scenarios"]
    played = f"{counted(chosen['count'], 'scenario')} of seed {chosen['seed']}"
    where = f", on {results['where']}" if "where" in results else ""  # files of 0.1 don't say
    head = f"The driver by its mode, pedestrians sampling; {played}, hash {chosen['hash']}{where}"
    return [
        f"{head}; 95 % intervals over scenarios:",
        "",
        f"| among | {' | '.join(FIGURES)} |",
        f"| --- |{' --- |' * len(FIGURES)}",
        *(
            f"| {name} | {' | '.join(shown(Interval(**cell[x]), _scale(x)) for x in FIGURES.values())} |"
            for name, cell in results["among"].items()
        ),
    ]


def _scale(figure: str) -> float:
    return 100.0 if figure.endswith("_rate") else 1.0
