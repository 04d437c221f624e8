"""The table of `jaxwalk evaluate`: what it marks, and how wide it is."""

from __future__ import annotations

import dataclasses
import io

import pytest
from rich.console import Console
from rich.measure import Measurement

from jaxwalk.cli import evaluation_table
from jaxwalk.cli.evaluation_table import OF_MAPS, WIDEST, table, tables
from report.material import material


def test_the_table_marks_who_sees_what_is_hidden():
    cell = material(1).results.cells[0]
    sets = ("route", "route-belief", "route-told", "privileged")
    shown = table([dataclasses.replace(cell, driver="mine", driver_observes=name) for name in sets], list(OF_MAPS))
    marked = ["mine", "mine", "mine (route-told)", "mine (privileged)"]
    assert list(shown.columns[0].cells) == marked


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_a_narrow_terminal_has_several_tables(width):
    cells = material(1).results.cells[:3]
    written = io.StringIO()
    console = Console(width=width, file=written)
    made = tables(cells, console)
    assert (len(made) == 1) == (width == 200)
    console.print(*made, sep="\n")
    text = written.getvalue()
    assert max(len(line) for line in text.splitlines()) <= width and "…" not in text
    assert all(text.count(name) == 1 for name in (*OF_MAPS, "95 % intervals in brackets"))
    assert text.count(cells[0].pedestrians) >= len(made)
    assert " ".join(text.split()).count("the world's rule, which ends scenarios, gives the hits of jaxwalk report") == 1


def test_numbers_at_their_widest_fit_into_a_file(monkeypatch):
    widest = "100.00 [100.00, 100.00]"
    time = {"time to goal [s]": "100.0 [100.0, 100.0]"}
    rates = {name: time.get(name, widest) for name in OF_MAPS}
    monkeypatch.setattr(evaluation_table, "OF_MAPS", {name: lambda _, text=text: text for name, text in rates.items()})
    contacts = {"moving car: disc / footprint %": "100.00 / 100.00", "preventable %": widest}
    monkeypatch.setattr(
        evaluation_table, "OF_CELLS", {name: lambda _, text=text: text for name, text in contacts.items()}
    )
    cell = dataclasses.replace(material(1).results.cells[0], driver="mine", pedestrians="always-go")
    made = table([cell, dataclasses.replace(cell, jaywalk_multiplier=9.25)], [*rates, *contacts])
    written = io.StringIO()
    console = Console(width=1000, file=written)
    console.print(made)
    assert "multiplier" in written.getvalue()
    assert Measurement.get(console, console.options, made).maximum == 223 < WIDEST
