"""Properties of a file's header that jaxwalk writes and reads: what OpenSCENARIO has no words for."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

from jaxwalk.maps import bundled_maps
from jaxwalk.maps.generated.named_streets import names_generated
from jaxwalk.scenarios.crash_suite import PassRule
from jaxwalk.scenarios.xosc.elements import XoscRefusal, number, word

PREFIX = "jaxwalk."
"""The names of our properties begin so."""


def street_name(name: str) -> str | None:
    """Return the name of a street if it says which street it is; None for files."""
    return name if name in bundled_maps() or names_generated(name) else None


@dataclass(frozen=True)
class OurProperties:
    """The properties of a file's header."""

    values: dict[str, str]

    @classmethod
    def of(cls, document: ET.Element) -> OurProperties:
        """Return those of a document."""
        properties = document.findall("FileHeader/Properties/Property")
        return cls({word(one, "name", ""): word(one, "value", "") for one in properties})

    @property
    def track(self) -> str | None:
        """Return the name of the street; None if the file names none, or one that isn't known."""
        return street_name(self.text("track"))

    @property
    def route(self) -> int:
        """Return the number of the car's route on the street that is named; 0 on a street that is made.

        Raise XoscRefusal if it is no whole number.
        """
        value = 0.0 if self.track is None else self.number("route", 0.0)
        if value < 0 or value != int(value):
            raise XoscRefusal(f"Property {PREFIX}route: {value:g} is no number of a route; write 0, 1, ...")
        return int(value)

    def text(self, name: str) -> str:
        """Return a property; an empty text if it isn't there."""
        return self.values.get(PREFIX + name, "")

    def number(self, name: str, default: float) -> float:
        """Return a number. Raise XoscRefusal if the property is none."""
        text = self.values.get(PREFIX + name)
        return default if text is None else number(ET.Element(f"Property {PREFIX}{name}", {"value": text}), "value")

    def passes(self) -> PassRule:
        """Return what a driver must do."""
        rules = {name: self.number(name, -1.0) for name in ("impact", "deceleration", "keeps")}
        return PassRule(**{name: value for name, value in rules.items() if value >= 0})
