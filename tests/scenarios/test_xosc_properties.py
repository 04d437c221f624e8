"""Properties that jaxwalk writes into headers: they count only together."""

from __future__ import annotations

import pytest

from jaxwalk.scenarios import Scripted
from scenarios.xosc_documents import document


def header(**properties):
    """Attributes of a header, and properties inside it."""
    inside = "".join(f'<Property name="jaxwalk.{name}" value="{value}"/>' for name, value in properties.items())
    return document().replace('01-01T00:00:00"/>', f'01-01T00:00:00"><Properties>{inside}</Properties></FileHeader>')


def test_a_route_counts_only_together_with_its_street(read, tmp_path):
    """A file of somebody's own map has a route, but no street that we know: one is made, and it has one route."""
    script = read(header(route=3))
    assert script.track is not None and script.suite.tests[0].route == 0
    assert int(Scripted.load(tmp_path / "by-hand.xosc").scenarios.route[0]) == 0
    assert read(header(route=3, track="mine.json")).suite.tests[0].route == 0


@pytest.mark.parametrize(
    ("properties", "message"),
    [
        ({"track": "paper", "route": "99"}, "Property jaxwalk.route: there is no route 99; correct it"),
        ({"track": "paper", "route": "0.5"}, "Property jaxwalk.route: 0.5 is no number of a route"),
        ({"track": "paper", "route": "-1"}, "Property jaxwalk.route: -1 is no number of a route"),
        ({"track": "test:20"}, "Property jaxwalk.track: "),
    ],
)
def test_wrong_properties_are_refused_in_words(check_refused, properties, message):
    check_refused(header(**properties), message)
