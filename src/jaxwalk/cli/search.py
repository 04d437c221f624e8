"""``jaxwalk search``."""

from __future__ import annotations

from functools import partial

from jaxwalk.cli.casting import cast
from jaxwalk.cli.checks import check_count, check_driver_seconds, check_seed
from jaxwalk.cli.errors import UsageError, bad_values
from jaxwalk.cli.interruption import until_interrupted
from jaxwalk.cli.options import Search
from jaxwalk.cli.told import told
from jaxwalk.experiments.failure_rate import FailureRate, estimate_rate
from jaxwalk.experiments.failure_search import FailureSearch, Tell, search_failures
from jaxwalk.policies.shield_names import with_shield
from jaxwalk.runs.effort import MOST_EPISODES
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import held
from jaxwalk.search.evolution import check_evosax
from jaxwalk.search.found_failures import SearchResults
from jaxwalk.search.splitting import SplittingPlan
from jaxwalk.wording import counted

MOST_PARTICLES = 100_000


def run(options: Search) -> int:
    """Search, and write what was found; return 130 if Ctrl-C ended it."""
    check(options)
    names = with_shield(options.drivers, options.shield)
    loading = {"trust": options.trust, "seconds": options.driver_seconds}
    street, drivers, people = cast(names, [options.pedestrians], options, **loading)
    if options.method == "splitting":
        with bad_values():
            plan = SplittingPlan(particles=options.particles, repeats=options.repeats)
        rate = FailureRate(street, drivers, people, plan, options.seed, options.out)
        work = partial(estimate_rate, rate)
    else:
        search = FailureSearch(
            street, drivers, people, options.method, options.simulations, options.minimise, options.seed, options.out
        )
        work = partial(_searched, options, search)
    with held(options.out):
        return until_interrupted(lambda: told("compiling", work))


def _searched(options: Search, search: FailureSearch, tell: Tell) -> str:
    """Search; return in words what was found."""
    return said(search_failures(search, tell), options)


def said(results: SearchResults, options: Search) -> str:
    """Return in words what was found, and where it is."""
    kinds = counted(len(results.failures), "kind")
    lines = [
        f"{results.driver.name}: {kinds} of failure in {counted(results.simulations, 'scenario')} ({results.method}), "
        f"{results.good} of them plausible and avoidable"
    ]
    if results.failures:
        lines.append(f"With any driver: jaxwalk evaluate --scenarios {options.out} --driver {results.driver.name}")
    return "\n".join([*lines, f"Open {options.out / 'search.html'}"])


def check(options: Search) -> None:
    """Raise UsageError for impossible options."""
    if len(options.drivers) != 1:
        named = (
            f"not {len(options.drivers)}" if options.drivers else "such as co-trained, a run folder or a policy file"
        )
        raise UsageError(f"name one driver to search, {named}")
    check_seed(options.seed)
    check_driver_seconds(options.driver_seconds)
    check_count("--simulations", options.simulations, 1, MOST_EPISODES)
    check_count("--minimise", options.minimise, 0, 1000)
    check_count("--particles", options.particles, 2, MOST_PARTICLES)
    check_count("--repeats", options.repeats, 2, 10_000)
    if options.method == "evolution":
        check_evosax()
    check_writable(options.out)
