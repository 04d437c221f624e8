"""A small OpenDRIVE file, written by hand: a straight road of two lanes and two sidewalks, with crosswalks."""

from __future__ import annotations

import math

LANE, WALK, LENGTH = 3.5, 2.0, 240.0
"""Widths of lanes and sidewalks, and the road's length [m]; it runs along y = 50."""
SIZE = f'length="{2 * LANE}" width="4"'
CORNERS = ((-LANE, -2), (LANE, -2), (LANE, 2), (-LANE, 2))
LOCAL = "".join(f'<cornerLocal u="{u + 1}" v="{v}" z="0"/>' for u, v in CORNERS)
"""The outline in the object's own metres; the object lies 1 m to the right of its middle."""
ON_ROAD = "".join(f'<cornerRoad s="{200 + v}" t="{u}" dz="0" height="0"/>' for u, v in CORNERS)
"""The outline along the road, at s = 200."""


def crosswalk(s, *, t=0.0, name="", kind="crosswalk", size=SIZE, outline=""):
    """A crosswalk straight over the road."""
    about = f'id="9" name="{name}" type="{kind}" s="{s}" t="{t}" zOffset="0" hdg="{math.pi / 2}" orientation="none"'
    return f"<object {about} {size}><outlines><outline>{outline}</outline></outlines></object>"


def _lane(number, kind):
    width = LANE if kind == "driving" else WALK
    speed = '<speed sOffset="0" max="30" unit="km/h"/>' if kind == "driving" else ""
    wide = f'<width sOffset="0" a="{width}" b="0" c="0" d="0"/>'
    return f'<lane id="{number}" type="{kind}" level="false">{wide}{speed}</lane>'


def drive_file(objects, *, rule="RHT", root="OpenDRIVE"):
    """The file."""
    left = _lane(2, "sidewalk") + _lane(1, "driving")
    right = _lane(-1, "driving") + _lane(-2, "sidewalk")
    return (
        f'<?xml version="1.0"?>\n<{root}><header revMajor="1" revMinor="6" name="" version="1"><geoReference>'
        "<![CDATA[+proj=utm +zone=33]]></geoReference></header>"
        f'<road name="Long road" length="{LENGTH}" id="1" junction="-1" rule="{rule}"><planView>'
        f'<geometry s="0" x="0" y="50" hdg="0" length="{LENGTH}"><line/></geometry></planView>'
        f'<lanes><laneSection s="0"><left>{left}</left><center><lane id="0" type="none"/></center>'
        f"<right>{right}</right></laneSection></lanes><objects>{objects}</objects></road></{root}>"
    )
