"""``jaxwalk scenario``."""

from __future__ import annotations

from jaxwalk.cli.options import Scenario, UsageError
from jaxwalk.cli.train import bad_values
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.exports.scenario_files import COMMONROAD, EPISODE, MAP, export_scenario
from jaxwalk.formats.opendrive import load_library
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.runs.folder import check_writable


def run(options: Scenario) -> int:
    """Play and write."""
    check(options)
    with bad_values():
        street = world_of([options.driver, options.pedestrians], options.map)
        street = with_jaywalk_multiplier(street, options.jaywalk_multiplier)
        driver = contestant(street, "driver", options.driver)
        people = contestant(street, "pedestrian", options.pedestrians)
    name = f"jaxwalk: {options.driver} among {options.pedestrians}, scenario {options.scenario} of seed {options.seed}"
    error = export_scenario(
        street, driver, people, options.out, scenario=options.scenario, seed=options.seed, name=name
    )
    files = f"{EPISODE} with {MAP}, and {COMMONROAD}"
    print(f"{options.out}: {files}; read back, nobody is off by more than {1000 * error:.4f} mm")
    return 0


def check(options: Scenario) -> None:
    """Raise for options that can't be."""
    if not options.driver:
        raise UsageError(
            "--driver is missing: a name such as co-trained or route-follower, a run folder or a policy file"
        )
    if not 0 <= options.scenario < 2**30:
        raise UsageError(f"--scenario must lie in [0, 2^30), not {options.scenario}")
    if not 0 <= options.seed < 2**31:
        raise UsageError(f"--seed must lie in [0, 2^31), not {options.seed}")
    if options.out.exists() and not options.out.is_dir():
        raise UsageError(f"--out {options.out}: is a file; name a folder")
    load_library()
    check_writable(options.out)
