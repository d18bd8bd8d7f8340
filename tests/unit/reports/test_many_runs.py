"""Comparisons in which more varies than algorithm, slave and level: lines, pictures and sentences tell runs apart."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest
from matplotlib.colors import to_hex

from contactlab.reports.cost_plot import cost_figure
from contactlab.reports.findings import sentence
from contactlab.reports.page import draw, page
from contactlab.reports.pressure_plot import pressure_figure
from contactlab.reports.series import series_styles
from contactlab.studies.table import Row, Table


def over(table: Table, key: str, values: list[object]) -> Table:
    """The finished runs of one algorithm, once for each value of a key."""
    good = [row for row in table.rows if row.algorithm == "beta"]
    rows = [
        replace(row, name=f"{row.name}-{value}", choices={key: value}, varied={**row.varied, key: value})
        for value in values
        for row in good
    ]
    return replace(table, rows=rows)


def test_lines_of_one_algorithm_are_told_apart_by_what_varies(table: Table) -> None:
    many = over(table, "contacts.0.friction.mu", [0.1, 0.2, 0.3])
    chosen = series_styles(many.rows)
    assert list(chosen) == ["mu 0.1", "mu 0.2", "mu 0.3"]
    assert len({(style.colour, style.marker) for style in chosen.values()}) == 3
    axes = cost_figure(many).axes[0]
    drawn = {to_hex(line.get_color()) for line in axes.lines if len(line.get_xdata()) > 1}
    assert len(drawn) == 3
    legend = axes.get_legend()
    assert legend is not None
    assert set(chosen) <= {text.get_text() for text in legend.get_texts()}
    for line in axes.lines:  # runs of other mu are no points of the same line
        assert all(a < b for a, b in pairwise(line.get_xdata()))


@pytest.mark.full
def test_more_than_twelve_pressures_are_a_map(table: Table) -> None:
    assert len(pressure_figure(over(table, "mu", [0.1, 0.2, 0.3])).axes) == 6
    many = over(table, "mu", [0.05 * k for k in range(1, 15)])
    figure = pressure_figure(many)
    (image,) = figure.axes[0].images
    assert image.get_array().shape[0] == len(many.main) + 1  # and the reference
    assert figure.get_size_inches()[1] < 10.0  # inches: a page, where 28 panels were seven of them
    text = page(many, draw(many))
    assert "pressure as colour" in text
    assert "Markers are" not in text


def test_the_page_says_what_agreeing_runs_share(table: Table) -> None:
    rows: list[Row] = []
    for mu in (0.1, 0.2):
        rows += [replace(row, choices={"mu": mu}, status="finished") for row in table.main if row.curve is not None]
    text = page(replace(table, rows=rows), {})
    assert "mu = 0.1" in text
    assert "mu = 0.2" in text


def test_nothing_is_best_among_errors_that_the_reference_cannot_tell(table: Table) -> None:
    # 0.810 % and 0.814 % against a reference known to 0.13 %; the second is the cheaper one
    errors, costs = (0.00814, 0.00810, 0.03), (1.0, 2.0, 0.1)
    rows = [
        replace(table.rows[2], slave=slave, measures={"pressure_error": error, "cpu_s": cost})
        for slave, error, cost in zip(("disc", "block", "disc"), errors, costs, strict=True)
    ]
    assert table.reference is not None
    rough = replace(table.reference, error_estimate={"pressure": 0.0013})
    told = sentence(replace(table, rows=rows, reference=rough))
    assert "2 of them are equally accurate" in told
    assert "(slave disc): 1.0 CPU seconds" in told
    exact = replace(table.reference, error_estimate={"pressure": 0.0})
    assert "most accurate with beta (slave block)" in sentence(replace(table, rows=rows, reference=exact))
