"""The figures of the report."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from matplotlib.figure import Figure

from jaxwalk.report.figures.driver_rates import ablation, baselines
from jaxwalk.report.figures.frontier import frontier
from jaxwalk.report.figures.learning_curves import learning_curves
from jaxwalk.report.figures.people import attribution, quarters, waiting
from jaxwalk.report.figures.speeds import speed_differential, surprise
from jaxwalk.report.figures.surrogates import surrogates
from jaxwalk.report.material import Material
from jaxwalk.report.style import drawing, save

FIGURES: dict[str, Callable[[Material], Figure]] = {
    "baselines": baselines,
    "frontier": frontier,
    "speed_differential": speed_differential,
    "surprise": surprise,
    "attribution": attribution,
    "quarters": quarters,
    "waiting": waiting,
    "surrogates": surrogates,
    "ablation": ablation,
    "learning_curves": learning_curves,
}
"""Every figure, by the name of its files."""


def draw_all(names: Iterable[str], material: Material, folder: Path, say: Callable[[str], None]) -> dict[str, str]:
    """Write the figures with these names; return their drawings for the page, by name.

    ``say`` is called with a line before each of them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    made = {}
    for name in names:
        say(f"    drawing the figure {name}")
        with drawing(name):
            made[name] = save(FIGURES[name](material), folder, name)
    return made
