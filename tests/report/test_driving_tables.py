"""What happens where nobody is hit, in two tables: each number stands under its own heading."""

from __future__ import annotations

from jaxwalk.evaluation import Cell
from jaxwalk.metrics import measure, summarise
from jaxwalk.report.driving_tables import driving, kerb
from jaxwalk.sim.crossing_kind import CROSSWALK
from metrics.scenes import Scene, Walk, trajectory

ENTERS = {"kerb": range(4, 10), "crossings": [(10, 30, CROSSWALK)], "miss": 1.0}
SCENES = (
    Scene(30, [Walk(22.0, 0.0, **ENTERS)]),
    Scene(30, [Walk(22.0, 0.0, waits=range(5, 8), **ENTERS)], acceleration={3: -3.0}),
    Scene(30, [Walk(6.0, 3.0, crossings=[(1, 30, CROSSWALK)])]),
)


def _shown(table):
    """The numbers of the only row by column, without intervals."""
    (row,) = table.rows
    return {column: text.split(" [")[0] for column, text in zip(table.columns, row, strict=True)}


def _cells():
    summary = summarise(measure(trajectory(*SCENES)), resamples=20)
    return [("mine", Cell("mine", "always-go", "mode", "sample", 0.25, summary, "route", "kerb"))]


def test_who_goes_first_at_the_kerb():
    assert _shown(kerb(_cells())) == {
        "driver": "mine", "approaches": "2", "wait %": "50.0", "enter in danger %": "100.00", "car yields %": "100.00",
        "accepted gap [s]": "3.0", "5 % shorter than [s]": "3.0", "largest gap let pass [s]": "3.5",
    }  # fmt: skip


def test_how_the_car_drives():
    # one harsh step of 90, in 45 m driven; it passes 3 - 0.9 - 0.25 m beside somebody
    found = _shown(driving(_cells()))
    assert found == {
        "driver": "mine", "harsh %": "1.1", "harsh per km": "22.2", "jerk [m/s³]": "0.0",
        "passing at 0 to 0.5 m [m/s]": "–", "passing at 0.5 to 1 m [m/s]": "–", "passing at 1 to 2 m [m/s]": "5.0",
        "passing at 2 to 5 m [m/s]": "5.0",
    }  # fmt: skip
