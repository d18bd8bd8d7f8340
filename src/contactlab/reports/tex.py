"""`table.tex`: the table of a comparison for an article."""

from __future__ import annotations

from contactlab.api.drawing.units import Units
from contactlab.reports.numbers import MISSING, heading_unit, quantity
from contactlab.reports.table import USUAL
from contactlab.studies.columns import Column
from contactlab.studies.table import Row, Table

SPECIAL = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "∞": r"$\infty$", "²": r"$^2$", "µ": r"$\mu$",
}  # fmt: skip


def table_tex(table: Table) -> str:
    """A `tabular` with a row per run of the study and the usual measures that any of them has."""
    rows = table.main
    keys = list(dict.fromkeys(key for row in rows for key in row.choices))
    known = {column.name: column for column in table.measures}
    wanted = [known[name] for name in table.study.measures or USUAL]
    columns = [c for c in wanted if any(row[c.name] == row[c.name] for row in rows)]
    units = Units.of_label(table.scene.get("units"))
    words = ("algorithm", "slave", *keys, "level", "status")
    lines = [
        f"% {table.study.name}; needs \\usepackage{{booktabs}}",
        rf"\begin{{tabular}}{{{'l' * len(words)}{'r' * len(columns)}}}",
        r"\toprule",
        _line([*map(escaped, words), *(escaped(column.title) for column in columns)]),
        _line([*("" for _ in words), *(_unit(column, units) for column in columns)]),
        r"\midrule",
        *(_line(_cells(row, keys, columns)) for row in rows),
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """A text with the characters that LaTeX takes for commands written out."""
    return "".join(SPECIAL.get(character, character) for character in text)


def _line(cells: list[str]) -> str:
    return " & ".join(cells) + r" \\"


def _unit(column: Column, units: Units) -> str:
    unit = heading_unit(column.unit, units[column.unit] if column.unit else "")
    return f"[{escaped(unit)}]" if unit else ""


def _cells(row: Row, keys: list[str], columns: list[Column]) -> list[str]:
    words = [row.algorithm, row.slave, *(str(row.choices.get(key, "")) for key in keys), str(row.level), row.status]
    return [*map(escaped, words), *(_number(quantity(row[c.name], c.unit, c.digits)) for c in columns)]


def _number(text: str) -> str:
    """A number as mathematics: 1.2e-5 becomes a power of ten."""
    if text == MISSING:
        return "--"
    mantissa, power, exponent = text.partition("e")
    return rf"${mantissa}\cdot 10^{{{int(exponent)}}}$" if power else f"${text}$".replace("∞", r"\infty")
