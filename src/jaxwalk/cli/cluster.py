"""``jaxwalk evaluate --cluster``: parts as tasks of Ray, put together when all are there."""

from __future__ import annotations

import os
import sys
from functools import partial
from pathlib import Path

from jaxwalk.cli.checks import check_count
from jaxwalk.cli.cluster_worker import PlayPart
from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.jax_start import for_workers
from jaxwalk.cli.options import Evaluate
from jaxwalk.cli.progress import with_progress
from jaxwalk.evaluation import Results, check_parquet
from jaxwalk.experiments.evaluating import Evaluation, Tell
from jaxwalk.experiments.in_parts import merge_parts
from jaxwalk.experiments.kept_parts import KeptParts, number_of_parts
from jaxwalk.experiments.on_ray import (
    AUTO,
    LOCAL,
    PlayedFiles,
    check_ray,
    connected,
    cores_of_cluster,
    play_on_ray,
)
from jaxwalk.provenance import cores
from jaxwalk.runs.effort import MOST_EPISODES
from jaxwalk.runs.lock import held

PARTS = "parts"
"""Folder of finished parts inside that of the results. It is removed when they have been put together."""


def evaluate_on_cluster(options: Evaluate, work: Evaluation, cluster: str, out: Path) -> Results:
    """Play all parts that aren't finished yet as tasks of a cluster, put them together, and remove them.

    Raises:
        PartError: there can't be that number of parts, or those in the folder are of another evaluation.
        ClusterError: the cluster can't be used, or can't play a part.
        InUseError: another process writes into the folder.
    """
    parts = number_of_parts(work, options.parts)
    with held(out):
        kept = KeptParts.of(work, out / PARTS, parts)
        if kept.missing():
            _play_missing(options, cluster, kept)
        merged = with_progress("merging", partial(merge_parts, kept.finished(), out))
        kept.remove()
    for line in merged.said:
        _say(line)
    return merged.results


def _play_missing(options: Evaluate, cluster: str, kept: KeptParts) -> None:
    """Play the parts that aren't finished on a cluster, and keep them. Raises ClusterError."""
    with connected(cluster, cores()) as scratch:
        play = PlayPart(options, os.getcwd(), for_workers(), scratch)
        with_progress("playing", partial(_play, kept, play))


def _play(kept: KeptParts, play: PlayPart, tell: Tell) -> None:
    """Play the missing parts on the connected cluster, and tell of each that is finished. If it ends early, say so."""
    missing, total = kept.missing(), kept.planned.episodes
    done = total - sum(map(kept.episodes, missing))
    what = f"playing {len(missing)} parts on {cores_of_cluster()} cores"

    def keep(part: str, files: PlayedFiles) -> None:
        nonlocal done
        kept.keep(part, files)
        done += kept.episodes(part)
        tell(what, done, total)

    tell(what, done, total)
    try:
        play_on_ray(play, missing, keep, _say)
    except BaseException:  # an interruption too
        finished = f"{len(kept.finished())} of {len(kept.names)} parts are finished"
        _say(f"{finished}, and kept in {kept.folder}; the same command goes on with the others")
        raise


def check_cluster(options: Evaluate, cluster: str) -> None:
    """Raise UsageError, ClusterError or MissingLibraryError for options that a cluster can't do."""
    if cluster not in (AUTO, LOCAL) and ":" not in cluster:
        raise UsageError(f"--cluster {cluster}: must be auto, local, ray://HOST:PORT or HOST:PORT")
    for name, why in (
        ("part", "a cluster plays all parts"),
        ("counterfactuals", "collisions aren't replayed in parts"),
        ("scenarios", "kept scenarios aren't evaluated in parts"),
    ):
        if getattr(options, name):
            raise UsageError(f"--{name}: {why}; leave it out, or leave out --cluster")
    if options.parts is not None:
        check_count("--parts", options.parts, 1, MOST_EPISODES)
    if options.out is None:
        raise UsageError("--cluster needs --out DIR, for results, and for finished parts meanwhile")
    check_parquet()
    check_ray()


def _say(line: str) -> None:
    print(line, file=sys.stderr)
