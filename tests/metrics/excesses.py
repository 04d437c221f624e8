"""Excesses for tests of tails."""

import numpy as np

from jaxwalk.metrics.pareto_tail import Excesses


def once(excesses):
    """Excesses that were seen once each."""
    return Excesses(np.array(excesses), np.ones(len(excesses), int))
