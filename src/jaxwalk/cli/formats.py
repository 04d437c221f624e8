"""``jaxwalk export`` and ``jaxwalk observations``."""

from __future__ import annotations

from jaxwalk.cli.options import Export, Observations, UsageError
from jaxwalk.cli.train import bad_values
from jaxwalk.runs.folder import check_writable
from jaxwalk.sim.observation import HIDDEN, OBSERVATIONS, part, size


def export(options: Export) -> int:
    """Write the file, and say how well it agrees."""
    from jaxwalk.exports.onnx_policy import LARGEST_GAP, export

    if options.out is None or options.out.suffix != ".onnx":
        raise UsageError(f"--out {options.out or 'FILE.onnx is missing'}: name a file that ends in .onnx")
    if options.out.is_dir():
        raise UsageError(f"--out {options.out}: is a folder; name a file")
    check_writable(options.out.parent)
    with bad_values():
        found = export(options.policy, options.out, role=options.role)
    what = "action" if options.role == "driver" else "logit"
    print(
        f"{options.out}: largest {what} gap {found.gap:.1e} over {found.rows:,} observations ({LARGEST_GAP:g} allowed)"
    )
    return 0


def observations(options: Observations) -> int:
    """Print every set of the role."""
    for name, features in OBSERVATIONS[options.role].items():
        hidden = ", which no real car could have" if name in HIDDEN else ""
        print(f"{name}: {size(options.role, name)} features{hidden}")
        for feature in features:
            place = part(options.role, name, feature.name)
            print(f"  {place.start:4d} to {place.stop - 1:4d}  {feature.name}")
    return 0
