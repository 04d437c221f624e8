"""Lines as OpenDRIVE's plan view: a straight line, or cubic polynomials that join smoothly."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType
from typing import NamedTuple

import numpy as np

from jaxwalk.maps.network import along

STRAIGHT = 1e-3
"""A line within this distance of its chord is straight [m]."""
PIECE = 2.0
"""Length of a polynomial, about [m]."""
LOOK = 0.5
"""The direction of a line is that between the points this far before and after [m]."""


class Cubic(NamedTuple):
    """A polynomial in the frame of its begin: u ahead, v to the left, for p from 0 to 1 [m]."""

    x: float
    y: float
    heading: float
    u: np.ndarray
    """Coefficients of 1, p, p2 and p3."""
    v: np.ndarray
    length: float


def plan_view(xodr: ModuleType, line: np.ndarray, headings: tuple[float, float]):
    """Return the plan view of a line (point, 2) whose directions at both ends are given [rad]."""
    view = xodr.PlanView()
    begin = line[0].tolist()
    if _is_straight(line, headings):
        view.add_fixed_geometry(xodr.Line(float(np.linalg.norm(line[-1] - line[0]))), *begin, headings[0])
        return view
    for x, y, heading, u, v, length in cubics(line, headings):
        form = xodr.ParamPoly3(*u.tolist(), *v.tolist(), prange="normalized", length=length)
        view.add_fixed_geometry(form, x, y, heading)
    return view


def _is_straight(line: np.ndarray, headings: tuple[float, float]) -> bool:
    chord = line[-1] - line[0]
    ahead = chord / np.linalg.norm(chord)
    aside = (line - line[0]) @ np.array([-ahead[1], ahead[0]])
    turns = np.exp(1j * np.array(headings)) * np.conj(complex(*ahead))
    return bool(np.abs(aside).max() < STRAIGHT and np.abs(np.angle(turns)).max() < STRAIGHT)


def cubics(line: np.ndarray, headings: tuple[float, float]) -> Iterator[Cubic]:
    """Yield polynomials through points of a line (point, 2), about `PIECE` apart, in its direction there."""
    metres = along(line)
    knots = np.linspace(0, metres[-1], max(1, round(metres[-1] / PIECE)) + 1)

    def at(s: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(s, metres, line[:, k]) for k in (0, 1)], axis=1)

    ahead = at(knots + LOOK) - at(knots - LOOK)
    angles = np.arctan2(ahead[:, 1], ahead[:, 0])
    angles[[0, -1]] = headings
    places = at(knots)
    for n in range(len(knots) - 1):
        yield _hermite(places[n], places[n + 1], angles[n], angles[n + 1])


def _hermite(begin: np.ndarray, end: np.ndarray, heading: float, next_heading: float) -> Cubic:
    """Return the polynomial from one point to another, with directions at both."""
    cos, sin, turn = np.cos(heading), np.sin(heading), next_heading - heading
    dx, dy = end - begin
    chord = float(np.hypot(dx, dy))
    u, v = (
        np.array([0.0, first, 3 * to - 2 * first - last, first + last - 2 * to])
        for to, first, last in (
            (cos * dx + sin * dy, chord, chord * np.cos(turn)),
            (cos * dy - sin * dx, 0.0, chord * np.sin(turn)),
        )
    )
    share = np.linspace(0, 1, 33)
    length = along(np.stack([np.polynomial.Polynomial(c)(share) for c in (u, v)], axis=1))[-1]
    return Cubic(float(begin[0]), float(begin[1]), float(heading), u, v, float(length))
