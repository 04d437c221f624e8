"""A small SUMO network, written by hand: a road of two lanes and two sidewalks, with a crossing in its middle."""

HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
LOCATION = '<location netOffset="0,0" convBoundary="0,0,240,100" origBoundary="0,0,240,100" projParameter="{proj}"/>'
WIDTH, WALK, LIMIT = 3.5, 2.0, 8.33
"""Of lanes and sidewalks [m]; [m/s]."""
MIDDLE, HALF = 120.0, 4.0
"""Where the crossing's junction is, and half its length [m]; the road runs along y = 50."""


def _edge(name, begin, end, x, sign, car):
    """An edge from x[0] to x[1] whose lanes lie to the right: ``sign`` is -1 towards the east."""
    lanes = []
    for index, (allow, width, aside, speed) in enumerate(
        [('allow="pedestrian"', WALK, WIDTH + WALK / 2, 2.78), (car, WIDTH, WIDTH / 2, LIMIT)]
    ):
        y = 50 + sign * aside
        lanes.append(
            f'<lane id="{name}_{index}" index="{index}" {allow} speed="{speed}" length="{abs(x[1] - x[0])}" '
            f'width="{width}" shape="{x[0]},{y} {x[1]},{y}"/>'
        )
    return f'<edge id="{name}" from="{begin}" to="{end}" priority="1" name="Long road">{"".join(lanes)}</edge>'


def _outline(x, y):
    """The corners of a rectangle."""
    return f"{x[0]},{y[0]} {x[0]},{y[1]} {x[1]},{y[1]} {x[1]},{y[0]}"


def road_net(*, state="M", signals=False, left=False, proj="!", comment="", car='disallow="pedestrian"', last=0):
    """The network; ``state`` is that of the links to the crossing, M: people have the right of way.

    ``last``: metres at the east end of the road that are an edge of their own to the east, and only to the east.
    """
    low, high = MIDDLE - HALF, MIDDLE + HALF
    side = 1 if left else -1
    parts = [LOCATION.format(proj=proj)]
    for name, x, y in ((":m_0", (low, high), 50 + side * WIDTH / 2), (":m_1", (high, low), 50 - side * WIDTH / 2)):
        parts.append(
            f'<edge id="{name}" function="internal"><lane id="{name}_0" index="0" {car} speed="{LIMIT}" length="8" '
            f'shape="{x[0]},{y} {x[1]},{y}"/></edge>'
        )
    parts.append(
        '<edge id=":m_c0" function="crossing" crossingEdges="east1 west2"><lane id=":m_c0_0" index="0" '
        f'allow="pedestrian" speed="2.78" length="7" width="4" shape="{MIDDLE},{50 - WIDTH} {MIDDLE},{50 + WIDTH}"/>'
        "</edge>"
    )
    for name, y in ((":m_w0", (50 - WIDTH - WALK, 50 - WIDTH)), (":m_w1", (50 + WIDTH, 50 + WIDTH + WALK))):
        parts.append(
            f'<edge id="{name}" function="walkingarea"><lane id="{name}_0" index="0" allow="pedestrian" speed="2.78" '
            f'length="8" width="2" shape="{_outline((low, high), y)}"/></edge>'
        )
    parts += [
        _edge("east1", "w", "m", (0, low), side, car),
        _edge("east2", "m", "k" if last else "e", (high, 240 - last), side, car),
        _edge("west1", "e", "m", (240, high), -side, car), _edge("west2", "m", "w", (low, 0), -side, car),
    ]  # fmt: skip
    parts += [_edge("east3", "k", "e", (240 - last, 240), side, car)] if last else []
    whole = _outline((low, high), (50 - WIDTH - WALK, 50 + WIDTH + WALK))
    for node, x, kind, shape in (
        ("w", 0, "dead_end", ""),
        ("m", MIDDLE, "priority", whole),
        ("e", 240, "dead_end", ""),
        *([("k", 240 - last, "priority", "")] if last else []),
    ):
        parts.append(f'<junction id="{node}" type="{kind}" x="{x}" y="50" incLanes="" intLanes="" shape="{shape}"/>')
    light = 'tl="m" linkIndex="0"' if signals else ""
    parts += [
        '<connection from="east1" to="east2" fromLane="1" toLane="1" via=":m_0_0" dir="s" state="M"/>',
        '<connection from="west1" to="west2" fromLane="1" toLane="1" via=":m_1_0" dir="s" state="M"/>',
        f'<connection from="east{3 if last else 2}" to="west1" fromLane="1" toLane="1" dir="t" state="M"/>',
        '<connection from=":m_0" to="east2" fromLane="0" toLane="1" dir="s" state="M"/>',
        '<connection from=":m_1" to="west2" fromLane="0" toLane="1" dir="s" state="M"/>',
        f'<connection from=":m_w0" to=":m_c0" fromLane="0" toLane="0" {light} dir="s" state="{state}"/>',
        '<connection from=":m_c0" to=":m_w1" fromLane="0" toLane="0" dir="s" state="M"/>',
    ]
    if last:
        parts.append('<connection from="east2" to="east3" fromLane="1" toLane="1" dir="s" state="M"/>')
    keeps = ' lefthand="true"' if left else ""
    return f'{HEAD}{comment}<net version="1.20"{keeps}>\n' + "\n".join(parts) + "\n</net>\n"
