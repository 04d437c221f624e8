"""Small OpenSCENARIO documents, made by hand: a car that drives east at 10 m/s, and somebody 40 m ahead."""

from __future__ import annotations

STEP = '<SpeedActionDynamics dynamicsShape="step" dynamicsDimension="time" value="0"/>'


def speed(value, dynamics=STEP):
    return (
        f"<PrivateAction><LongitudinalAction><SpeedAction>{dynamics}<SpeedActionTarget>"
        f'<AbsoluteTargetSpeed value="{value}"/></SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>'
    )


def world(x, y, heading=0.0):
    return f'<Position><WorldPosition x="{x}" y="{y}" h="{heading}"/></Position>'


def teleport(position):
    return f"<PrivateAction><TeleportAction>{position}</TeleportAction></PrivateAction>"


def follow(points, times=(), timing="<None/>"):
    stamps = [f' time="{time}"' for time in times] or [""] * len(points)
    vertices = "".join(f"<Vertex{stamp}>{world(*point)}</Vertex>" for stamp, point in zip(stamps, points, strict=True))
    return (
        '<PrivateAction><RoutingAction><FollowTrajectoryAction><Trajectory name="way" closed="false"><Shape><Polyline>'
        f"{vertices}</Polyline></Shape></Trajectory><TimeReference>{timing}</TimeReference>"
        '<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    )


RELATIVE = '<Timing domainAbsoluteRelative="relative" scale="1" offset="0"/>'


def body(kind, name, attributes, size=(4.5, 1.8), ahead=1.25):
    return (
        f'<ScenarioObject name="{name}"><{kind} name="a {kind.lower()}" {attributes}><BoundingBox>'
        f'<Center x="{ahead}" y="0" z="0.9"/><Dimensions length="{size[0]}" width="{size[1]}" height="1.8"/>'
        f"</BoundingBox><Properties/></{kind}></ScenarioObject>"
    )


EGO = body("Vehicle", "Ego", 'vehicleCategory="car"')
WALKER = body("Pedestrian", "walker", 'pedestrianCategory="pedestrian" mass="75"', (0.5, 0.5), 0.0)


def event(actions, condition="", name="walks", actor="walker"):
    trigger = f"<StartTrigger><ConditionGroup>{condition}</ConditionGroup></StartTrigger>" if condition else ""
    inside = "".join(f'<Action name="{name} {n}">{action}</Action>' for n, action in enumerate(actions))
    return (
        f'<ManeuverGroup name="{name} group" maximumExecutionCount="1"><Actors selectTriggeringEntities="false">'
        f'<EntityRef entityRef="{actor}"/></Actors><Maneuver name="{name} maneuver">'
        f'<Event name="{name}" priority="override">{inside}{trigger}</Event></Maneuver></ManeuverGroup>'
    )


def by_value(value, delay=0):
    inside = f"<ByValueCondition>{value}</ByValueCondition>"
    return f'<Condition name="c" delay="{delay}" conditionEdge="none">{inside}</Condition>'


def by_car(value, delay=0, who="Ego"):
    return (
        f'<Condition name="c" delay="{delay}" conditionEdge="none"><ByEntityCondition><TriggeringEntities '
        f'triggeringEntitiesRule="any"><EntityRef entityRef="{who}"/></TriggeringEntities><EntityCondition>{value}'
        "</EntityCondition></ByEntityCondition></Condition>"
    )


def document(
    events="", *, walker=None, car=None, entities=EGO + WALKER, header='revMajor="1" revMinor="2"', more="", init=""
):
    """Return a document: by default the car's rear axle is at (0, 0), its centre at 1.25 m, its front at 3.5 m."""
    car = teleport(world(0, 0)) + speed(10) if car is None else car
    walker = teleport(world(43.5, -4, 1.5707963)) if walker is None else walker
    act = f'<Story name="s"><Act name="a">{events}</Act></Story>' if events else ""
    return (
        f'<OpenSCENARIO><FileHeader {header} description="by hand" author="us" date="2026-01-01T00:00:00"/>{more}'
        f'<Entities>{entities}</Entities><Storyboard><Init><Actions>{init}<Private entityRef="Ego">{car}</Private>'
        f'<Private entityRef="walker">{walker}</Private></Actions></Init>{act}'
        "<StopTrigger/></Storyboard></OpenSCENARIO>"
    )


def crossing(condition):
    """The event that the walker crosses at 2 m/s."""
    return event([follow([(43.5, -4), (43.5, 6)]), speed(2)], condition)


TIME = '<SimulationTimeCondition value="{}" rule="greaterThan"/>'
PARKED = body("Vehicle", "van", 'vehicleCategory="van"', (6.0, 2.0), 1.0)
ROAD = """<OpenDRIVE><header/><road id="7" length="200" junction="-1"><planView>
<geometry s="0" x="-10" y="2" hdg="0" length="200"><line/></geometry></planView><lanes><laneOffset s="0" a="0.5" b="0"
c="0" d="0"/><laneSection s="0"><left><lane id="1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane>
</left><center><lane id="0"/></center><right><lane id="-1" type="driving"><width sOffset="0" a="4" b="0" c="0" d="0"/>
</lane><lane id="-2" type="sidewalk"><width sOffset="0" a="2" b="0" c="0" d="0"/></lane></right></laneSection></lanes>
</road></OpenDRIVE>"""
"""A road to the east: its lanes meet at y = 2.5; the middle of lane -1 is at 0.5, of -2 at -2.5, of 1 at 4."""
