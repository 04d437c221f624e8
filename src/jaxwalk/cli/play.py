"""``jaxwalk play``."""

from __future__ import annotations

from jaxwalk.cli.options import Play, UsageError
from jaxwalk.cli.train import bad_values
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.experiments.contestants import contestant, world_of
from jaxwalk.experiments.episodes import MOVING, draw_episode
from jaxwalk.experiments.runs import check_writable

STILL = (".png", ".svg", ".pdf")
"""Kinds of pictures."""


def run(options: Play) -> int:
    """Play one scenario and draw it."""
    check(options)
    with bad_values():
        street = world_of([options.driver, options.pedestrians], options.map)
        street = with_jaywalk_multiplier(street, options.jaywalk_multiplier)
        trust, seconds = options.trust, options.driver_seconds
        driver = contestant(street, "driver", options.driver, trust=trust, seconds=seconds)
        people = contestant(street, "pedestrian", options.pedestrians)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    played = draw_episode(street, driver, people, options.out, scenario=options.scenario, seed=options.seed)
    ending = "goal" if played.goal[0] else "collision" if played.collision[0] else "timeout"
    print(f"{options.out}: scenario {options.scenario} of seed {options.seed}: {ending} after", end=" ")
    print(f"{played.length[0] * played.dt:.1f} s")
    return 0


def check(options: Play) -> None:
    """Raise for options that can't be."""
    if not options.driver:
        raise UsageError(
            "--driver is missing: a name such as co-trained or route-follower, a run folder or a policy file"
        )
    if not 0 <= options.scenario < 2**30:
        raise UsageError(f"--scenario must lie in [0, 2^30), not {options.scenario}")
    if not 0 <= options.seed < 2**31:
        raise UsageError(f"--seed must lie in [0, 2^31), not {options.seed}")
    kinds = (*STILL, *MOVING)
    if options.out.suffix.lower() not in kinds:
        raise UsageError(f"--out {options.out}: the name must end in one of {', '.join(kinds)}")
    if options.out.is_dir():
        raise UsageError(f"--out {options.out}: is a folder; name a file")
    if options.out.suffix.lower() == ".mp4":
        _check_film(options)
    check_writable(options.out.parent)


def _check_film(options: Play) -> None:
    from importlib.util import find_spec

    if find_spec("imageio_ffmpeg") is None:
        raise UsageError(f"--out {options.out}: MP4 needs `pip install 'jaxwalk[video]'`; or name a .gif")
