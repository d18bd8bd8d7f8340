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
from contactlab.reports.series import series_of, series_styles
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


@pytest.mark.parametrize("count", [6, 30, 60])
def test_styles_of_many_lines_differ(table: Table, count: int) -> None:
    chosen = series_styles(over(table, "contacts.0.friction.mu", [0.01 * k for k in range(count)]).rows)
    assert len({(style.colour, style.marker) for style in chosen.values()}) == count


def test_keys_that_end_alike_are_written_longer(table: Table) -> None:
    (row, *_) = table.rows
    both = replace(row, choices={"bodies.disc.element": "q1", "bodies.block.element": "q2"})
    assert series_of(both, [both]) == "disc.element q1, block.element q2"


def test_panels_of_one_algorithm_follow_each_other_in_rows(table: Table) -> None:
    """Names of panels lie over them: beside a column of them they ran into each other."""
    many = over(table, "bodies.disc.element", ["q1", "q1-fbar", "q1-reduced", "q2"])
    panels = [axes for axes in pressure_figure(many).axes if axes.get_visible()]
    assert len(panels) == len({(row.slave, str(row.choices)) for row in many.main}) > 3
    places = [axes.get_subplotspec() for axes in panels]
    assert {place.colspan.start for place in places if place is not None} == {0, 1, 2}
    titles = [axes.get_title(loc="left").replace("\n", " ") for axes in panels]
    assert len(set(titles)) == len(titles)
    assert all("element" in title for title in titles)
    assert not any(axes.get_ylabel() for axes in panels)


def test_more_than_twelve_pressures_are_a_map(table: Table) -> None:
    assert len(pressure_figure(over(table, "mu", [0.1, 0.2, 0.3])).axes) == 6
    many = over(table, "mu", [0.05 * k for k in range(1, 15)])
    figure = pressure_figure(many)
    (image,) = figure.axes[0].images
    assert image.get_array().shape[0] == len(many.main) + 1  # and the reference
    assert figure.get_size_inches()[1] < 10.0  # inches: a page, where 28 panels were seven of them
    assert "pressure as colour" in page(many, draw(many))
    assert "Markers are" not in page(many, draw(many))


def test_a_map_reaches_the_largest_pressure_unless_it_is_far_above_the_others(table: Table) -> None:
    many = over(table, "mu", [0.05 * k for k in range(1, 15)])

    def times(row: Row, factor: float) -> Row:
        assert row.curve is not None
        return replace(row, curve=replace(row.curve, pressure=factor * row.curve.pressure))

    rows = [times(row, 1.0 + k / 14) for k, row in enumerate(many.rows)]
    raised = replace(many, rows=rows)
    largest = max(row.profile.value.max() for row in raised.main if row.profile is not None)
    (image,) = pressure_figure(raised).axes[0].images
    assert image.norm.vmax == pytest.approx(largest)
    (image,) = pressure_figure(replace(many, rows=[times(rows[0], 50.0), *rows[1:]])).axes[0].images
    assert image.norm.vmax < 2.0 * largest


def test_the_page_says_what_agreeing_runs_share(table: Table) -> None:
    rows: list[Row] = []
    for mu in (0.1, 0.2):
        rows += [replace(row, choices={"mu": mu}, status="finished") for row in table.main if row.curve is not None]
    text = page(replace(table, rows=rows), {})
    assert "mu = 0.1" in text
    assert "mu = 0.2" in text


def test_without_a_reference_there_is_no_empty_plot(table: Table) -> None:
    rows = [replace(row, measures={"cpu_s": 1.0}) for row in table.rows]
    assert "error-against-cost" not in draw(replace(table, rows=rows, reference=None))


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
