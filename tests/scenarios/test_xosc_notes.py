"""What of a file isn't played is said, each in a line of the page."""

from __future__ import annotations

import pytest

from scenarios.xosc_documents import EGO, ROAD, TIME, WALKER, by_car, by_value, document, event, speed, teleport, world

LIGHT = "<PrivateAction><AppearanceAction/></PrivateAction>"
OWN = "<UserDefinedAction><CustomCommandAction/></UserDefinedAction>"
CONTROLLED = WALKER.replace("</ScenarioObject>", "<ObjectController/></ScenarioObject>")
WEATHER = "<GlobalAction><EnvironmentAction/></GlobalAction>"
PLACE = teleport(world(43.5, -4))
CAR = teleport(world(0, 0)) + speed(10)
STOP = "<StopTrigger><ConditionGroup>{}</ConditionGroup></StopTrigger>"

DRIVEN = '<TraveledDistanceCondition value="50"/>'


def ends(condition):
    return document().replace("<StopTrigger/>", STOP.format(condition))


NOTES = {
    "init": (document(walker=PLACE + LIGHT), "AppearanceAction of walker isn't played"),
    "the car's init": (document(car=CAR + LIGHT), "AppearanceAction of Ego isn't played"),
    "event": (document(event([LIGHT])), "Event 'walks' of walker: AppearanceAction isn't played"),
    "beside another": (document(event([speed(1), LIGHT])), "Event 'walks' of walker: AppearanceAction isn't played"),
    "the car's event": (document(event([LIGHT], actor="Ego")), "Event 'walks' of Ego: AppearanceAction isn't played"),
    "own": (document(event([OWN])), "Event 'walks' of walker: UserDefinedAction isn't played"),
    "weather": (document(init=WEATHER), "EnvironmentAction of the file isn't played"),
    "controller": (document(entities=EGO + CONTROLLED), "ObjectController of walker isn't played"),
    "place": (ends(by_car(DRIVEN)), "StopTrigger: TraveledDistanceCondition isn't played"),
    "early": (ends(by_value(TIME.format(10))), "StopTrigger: the file ends at 10 s, the test at 20 s at the latest"),
    "late": (ends(by_value(TIME.format(100))), "StopTrigger: the file ends at 100 s, the test at 60 s at the latest"),
}  # fmt: skip


@pytest.mark.parametrize("case", NOTES)
def test_what_is_passed_over_is_said(read, case):
    text, note = NOTES[case]
    assert note in read(text).suite.assumed


def test_nothing_more_is_said(read):
    """The end of the test is the file's."""
    assert len(read(ends(by_value(TIME.format(30)))).suite.assumed) == 1
    assert read(ends(by_value(TIME.format(30)))).suite.lasts == 30


def test_what_is_said_of_the_street(read, tmp_path):
    """Only where the car begins on a lane is the roadway as wide as the file's."""
    (tmp_path / "road.xodr").write_text(ROAD)
    network = '<RoadNetwork><LogicFile filepath="road.xodr"/></RoadNetwork>'
    lane = '<Position><LanePosition roadId="7" laneId="-1" s="10" offset="0"/></Position>'
    said = [read(text).suite.assumed[0] for text in (
        document(), document(more=network), document(car=teleport(lane) + speed(10), more=network),
    )]  # fmt: skip
    two_lanes = "its roadway two lanes of 3.5 m, with sidewalks."
    along = "the street is made along the way of the car"
    assert said == [
        f"The file names no road: {along}, {two_lanes}",
        f"The road of LogicFile road.xodr isn't played: {along}, {two_lanes}",
        f"The road of LogicFile road.xodr isn't played: {along}, its roadway as wide as there where the car begins, "
        "with sidewalks.",
    ]
