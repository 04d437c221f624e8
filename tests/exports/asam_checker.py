"""Checks OpenSCENARIO files with ASAM's own rules: run by a Python that has asam-qc-openscenarioxml.

`python asam_checker.py FILE...` prints a line for each fault, and ends with exit code 1 if there is one.
"""

from __future__ import annotations

import logging
import sys

from qc_baselib import Configuration, Result, StatusType  # pyright: ignore[reportMissingImports]
from qc_openscenario import constants, main  # pyright: ignore[reportMissingImports]

NEEDED = ("valid_schema", "resolvable_entity_references", "unique_element_names_on_same_level")
"""Checks that must have run, by the ends of their names: others are skipped where a file has nothing for them."""


def faults(path: str) -> list[str]:
    """Return the faults of a file, one line each."""
    config, result = Configuration(), Result()
    config.set_config_param("InputFile", path)
    result.register_checker_bundle(
        name=constants.BUNDLE_NAME, description="", version=constants.BUNDLE_VERSION, summary=""
    )
    result.set_result_version(version=constants.BUNDLE_VERSION)
    main.run_checks(config, result)
    checks = result.get_checker_results(constants.BUNDLE_NAME)
    found = [f"{path}: {check.checker_id}: {issue.description}" for check in checks for issue in check.issues]
    for name in NEEDED:
        if not any(check.checker_id.endswith(name) and check.status == StatusType.COMPLETED for check in checks):
            found.append(f"{path}: {name} wasn't checked")
    return found


if __name__ == "__main__":
    logging.disable(logging.CRITICAL)
    lines = [line for path in sys.argv[1:] for line in faults(path)]
    print(*lines, f"{len(sys.argv) - 1} files, {len(lines)} faults", sep="\n")
    sys.exit(bool(lines))
