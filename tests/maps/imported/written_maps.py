"""Writing map files, and what each format's road with one crossing must be."""

from __future__ import annotations

from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.imported.street_maker import DISTANCES


def written_as(folder, text, name):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def only_crossing(source, street):
    """The crossing of a sound street on which nothing is invented, and the same in its source."""
    assert network_faults(street.network, **DISTANCES) == []
    assert street.report.verdict == "usable" and street.report.pavement.invented == 0
    (crossing,), (found,) = street.network.crossings, source.crossings
    assert crossing.kind == "zebra" and crossing.zone is not None
    return crossing, found
