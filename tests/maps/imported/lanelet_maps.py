"""A small Lanelet2 map, written by hand: a road of two lanelets and two walkways, with a crosswalk in its middle."""

from __future__ import annotations

LANE, WALK, LENGTH, MIDDLE, HALF = 3.5, 2.0, 240.0, 120.0, 2.0
"""Widths of lanes and walkways, the road's length, and where the crosswalk is and half its width [m]; y = 0 is the
middle of the road."""
HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n<osm version="0.6" generator="by hand">\n'


class LaneletMap:
    """Nodes, ways and relations, with metres of their own unless ``degrees`` are wanted."""

    def __init__(self, *, degrees=False):
        self.degrees, self.parts, self.count, self.nodes = degrees, [], 0, {}

    def line(self, *points, kind="line_thin", subtype=""):
        """A line of points (x, y), which share nodes with others; its number."""
        refs = [self._node(point) for point in points]
        tags = {"type": kind, "subtype": subtype}
        return self._add("way", "".join(f'<nd ref="{n}"/>' for n in refs), tags)

    def lanelet(self, left, right, *, rules=(), **tags):
        """A lanelet between two lines."""
        return self.relation({"left": [left], "right": [right]}, rules, type="lanelet", **tags)

    def relation(self, ways, rules=(), **tags):
        """A relation of ways by their roles, and of rules."""
        members = [("way", ref, role) for role, refs in ways.items() for ref in refs]
        members += [("relation", ref, "regulatory_element") for ref in rules]
        inner = "".join(f'<member type="{kind}" ref="{ref}" role="{role}"/>' for kind, ref, role in members)
        return self._add("relation", inner, tags)

    def text(self):
        """The file."""
        order = sorted(self.parts, key=lambda x: ("<node", "<way", "<relation").index(x.split(" ")[0]))
        return HEAD + '<MetaInfo format_version="1"/>\n' + "\n".join(order) + "\n</osm>\n"

    def _node(self, point):
        if point not in self.nodes:
            x, y = point
            place = {"local_x": x, "local_y": y, "ele": 3.0} if not self.degrees else {"ele": 3.0}
            where = (
                f' lat="{49 + y / 111_208.5:.10f}" lon="{8.4 + x / 73_170.2:.10f}"'
                if self.degrees
                else ' lat="" lon=""'
            )
            self.nodes[point] = self._add("node", "", place, where)
        return self.nodes[point]

    def _add(self, element, inner, tags, attributes=""):
        self.count += 1
        said = "".join(f'<tag k="{key.replace("__", ":")}" v="{value}"/>' for key, value in tags.items())
        self.parts.append(f'<{element} id="{self.count}"{attributes}>{inner}{said}</{element}>')
        return self.count


def road_map(*, left=False, degrees=False, markings="zebra_marking", kerb="curbstone", lights=False, **tags):
    """The map; ``tags`` are those of the road's lanelets, colons in them written as two underscores."""
    made = LaneletMap(degrees=degrees)
    edges = [made.line((0, y), (LENGTH, y), kind=kerb) for y in (-LANE, LANE)]
    middle = made.line((LENGTH, 0), (0, 0), subtype="dashed")
    rules = []
    if lights:
        light = made.line((MIDDLE, -LANE - 1), (MIDDLE, -LANE - 1.5), kind="traffic_light")
        rules = [made.relation({"refers": [light]}, type="regulatory_element", subtype="traffic_light")]
    about = {"subtype": "road", "speed_limit": "30"} | tags
    sides = [(middle, edges[0]), (middle, edges[1])] if not left else [(edges[0], middle), (edges[1], middle)]
    for one, other in sides:
        made.lanelet(one, other, **about)
    for sign, edge in ((-1, edges[0]), (1, edges[1])):
        outer = made.line((0, sign * (LANE + WALK)), (LENGTH, sign * (LANE + WALK)), kind="wall")
        made.lanelet(edge, outer, subtype="walkway")
    ways = [made.line((x, -LANE), (x, LANE), kind=markings) for x in (MIDDLE - HALF, MIDDLE + HALF)]
    made.lanelet(*ways, rules=rules, subtype="crosswalk")
    return made
