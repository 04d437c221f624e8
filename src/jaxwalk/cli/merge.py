"""``jaxwalk merge``."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.evaluate import show
from jaxwalk.cli.options import Merge
from jaxwalk.cli.progress import with_progress
from jaxwalk.evaluation import check_parquet
from jaxwalk.evaluation.parts import read_parts
from jaxwalk.experiments.in_parts import merge_parts
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import held


def run(options: Merge) -> int:
    """Put parts together, and show the results."""
    folders = [Path(name) for name in options.parts]
    out = _checked_out(options.out, folders)
    check_parquet()
    parts = read_parts(folders)
    with held(out):
        merged = with_progress("merging", partial(merge_parts, parts, out))
    for line in merged.said:
        print(line, file=sys.stderr)
    show(merged.results, as_json=options.json)
    return 0


def _checked_out(out: Path | None, folders: list[Path]) -> Path:
    """Return the folder to write into. Raise UsageError if there is none or it is a part's, or without parts."""
    if not folders:
        raise UsageError("name the folders of all parts, such as parts/*")
    if out is None:
        raise UsageError("--out DIR is missing: where the results are to be")
    if out.resolve() in [folder.resolve() for folder in folders]:
        raise UsageError(f"--out {out}: is the folder of a part; name another one")
    check_writable(out)
    return out
