"""Checks that a part of your own works with the rest: call one, and its message says what doesn't hold.

jaxwalk's own environments, drivers, pedestrians, metrics and sources pass the same checks.
"""

from jaxwalk.testing.environment_contract import check_environment
from jaxwalk.testing.policy_contract import check_driver, check_pedestrians, check_policy
from jaxwalk.testing.requirement import ContractError
from jaxwalk.testing.source_contract import check_source

__all__ = [
    "ContractError",
    "check_driver",
    "check_environment",
    "check_pedestrians",
    "check_policy",
    "check_source",
]
