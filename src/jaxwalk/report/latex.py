"""Write tables as LaTeX for papers: with booktabs, to be included with ``\\input``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from jaxwalk.report.table import NONE, Table
from jaxwalk.writing import write_whole

_SIGNS = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "–": "--",
    "²": r"\textsuperscript{2}",
    "×": r"\texttimes{}",
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
}
"""Characters that LaTeX would not print as they are."""


def write_latex(tables: Mapping[str, Table], captions: Mapping[str, str], folder: Path) -> None:
    """Write a ``.tex`` file for each table, with the caption of its name and the label ``tab:name``."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in tables.items():
        write_whole(folder / f"{name}.tex", latex_table(table, captions[name], name))


def latex_table(table: Table, caption: str, name: str) -> str:
    """Return one table as a float over the whole page width."""
    numeric = [all(_is_number(row[i]) for row in table.rows) for i in range(len(table.columns))]
    lines = [
        r"% needs \usepackage{booktabs}; too wide a table fits with \small, or \resizebox",
        r"\begin{table*}",
        r"\centering",
        rf"\caption{{{escaped(caption)}}}",
        rf"\label{{tab:{name}}}",
        rf"\begin{{tabular}}{{{''.join('r' if right else 'l' for right in numeric)}}}",
        r"\toprule",
        _row(table.columns),
        r"\midrule",
        *map(_row, table.rows),
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table*}",
    ]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """Return the text with LaTeX's special characters escaped."""
    return "".join(_SIGNS.get(sign, sign) for sign in text)


def _row(cells: tuple[str, ...]) -> str:
    return " & ".join(map(escaped, cells)) + r" \\"


def _is_number(cell: str) -> bool:
    return cell == NONE or cell[:1].isdigit() or cell[:1] in ("-", "<")
