"""``jaxwalk share``."""

from __future__ import annotations

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, TaskID

from jaxwalk.cli.checks import check_episodes, check_file, check_pedestrians, check_seed
from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.options import Share
from jaxwalk.exports.sharing import Judging, share
from jaxwalk.runs.contestants import ANYWHERE
from jaxwalk.runs.folder import check_writable
from jaxwalk.sim.suites import SUITES


def run(options: Share) -> int:
    """Evaluate the driver, then write the policy file and its card."""
    if options.out is None:
        raise UsageError("--out FILE.safetensors is missing: where to write the policies")
    check_file(options.out, ".safetensors")
    card = options.out.with_suffix(".md")
    if card.exists() and not options.out.exists():
        raise UsageError(f"--out {options.out}: its card would replace {card}; choose another name")
    check_pedestrians(options.pedestrians)
    check_episodes(options.episodes)
    check_seed(options.seed)
    check_writable(options.out.parent)
    where = SUITES[options.suite] if options.suite else ANYWHERE
    judging = Judging(options.pedestrians, options.episodes, options.seed, where)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        tasks: dict[str, TaskID] = {}

        def tell(driver: str, people: str, played: int, episodes: int) -> None:
            if people not in tasks:
                tasks[people] = bar.add_task(escape(f"among {people}"), total=episodes)
            bar.update(tasks[people], completed=played)

        card = share(options.run_folder, options.out, judging, progress=tell)
    print(f"{options.out} and {card}")
    return 0
