"""``jaxwalk export``."""

from __future__ import annotations

from jaxwalk.cli.checks import check_no_folder
from jaxwalk.cli.errors import UsageError, bad_values
from jaxwalk.cli.options import Export
from jaxwalk.exports.onnx_policy import LARGEST_GAP, export
from jaxwalk.runs.folder import check_writable


def run(options: Export) -> int:
    """Write the file, and print how well it agrees with the policy."""
    if options.out is None or options.out.suffix != ".onnx":
        raise UsageError(f"--out {options.out or 'FILE.onnx is missing'}: name a file that ends in .onnx")
    check_no_folder(options.out)
    check_writable(options.out.parent)
    with bad_values():
        found = export(options.policy, options.out, role=options.role)
    what = "action" if options.role == "driver" else "logit"
    print(
        f"{options.out}: largest {what} gap {found.gap:.1e} over {found.rows:,} observations ({LARGEST_GAP:g} allowed)"
    )
    return 0
