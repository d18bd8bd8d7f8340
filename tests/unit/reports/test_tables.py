"""Tables on a terminal: everything in them, and they fit."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from contactlab.api import RunWarning
from contactlab.api.drawing.units import Units
from contactlab.reports.findings import findings, sentence, span
from contactlab.reports.numbers import percent, significant, uncertain
from contactlab.reports.run import render_run
from contactlab.reports.table import USUAL, WIDTH, print_table, render
from contactlab.results.results import ContactCurve, ContactHistory, Results
from contactlab.studies.table import Row, Table


def shown(renderable: object, width: int = WIDTH) -> str:
    console = Console(file=io.StringIO(), width=width)
    console.print(renderable)
    return console.file.getvalue()  # type: ignore[attr-defined, no-any-return]


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (0.0, 3, "0"),
        (60.321, 5, "60.321"),
        (2129.5, 5, "2129.5"),
        (0.0123456, 2, "0.012"),
        (9.87e-7, 2, "9.9e-7"),
        (-4.5e8, 2, "-4.5e8"),
        (12.0, 3, "12.0"),
        (12345.0, 0, "12345"),
        (0.99999, 2, "1.0"),
        (math.nan, 3, "\N{EN DASH}"),
        (math.inf, 3, "∞"),
    ],
)
def test_significant_digits(value: float, digits: int, text: str) -> None:
    assert significant(value, digits) == text


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [(60.3214, 0.002, "60.321 ± 0.002"), (3912.3, 4.2, "3912 ± 4"), (1234.5, 96.0, "1234 ± 96"), (2.0, 0.0, "2.00000")],
)
def test_values_end_where_their_error_begins(value: float, error: float, text: str) -> None:
    assert uncertain(value, error) == text


def test_percent() -> None:
    assert percent(0.01234, 3) == "1.23"


@pytest.mark.parametrize(
    ("label", "pressure", "force", "energy"),
    [
        ("mm N s t", "MPa", "N/mm", "mJ/mm"),
        ("m N s kg", "Pa", "N/m", "J/m"),
        ("in lbf s x", "lbf/in²", "lbf/in", "lbf in/in"),
        ("", "", "", ""),
    ],
)
def test_units_follow_from_the_label(label: str, pressure: str, force: str, energy: str) -> None:
    units = Units.of_label(label)
    assert (units.pressure, units.line_force, units.line_energy) == (pressure, force, energy)


class TestComparison:
    def test_every_run_has_a_line_and_every_failure_its_reason(self, table: Table) -> None:
        text = shown(render(table))
        lines = text.splitlines()
        for row in table:
            assert any(row.algorithm in line and row.slave in line and row.status in line for line in lines)
        joined = " ".join(text.split())
        for row in table.failed:
            assert row.reason in joined

    def test_a_kind_of_warning_has_one_line_with_the_worst_run(self, table: Table) -> None:
        def warned(row: Row, value: float) -> Row:
            seen = RunWarning("other-slave", value, 2.0, "contacts.0.swap", f"segments are {value:g} times as long")
            return replace(row, warnings=[seen])

        rows = [warned(row, 3.0 + k) if k in (2, 3) else row for k, row in enumerate(table.rows)]
        text = " ".join(shown(render(replace(table, rows=rows))).split())
        assert text.count("finished !") == 2
        assert "! other-slave: beta, slave block, level 2 (worst of 2 runs): segments are 6 times as long" in text
        assert "segments are 5 times" not in text

    def test_the_usual_table_fits_with_cost_and_all(self, table: Table) -> None:
        wide = {"reaction": 12345.678, "steps": 123456.0, "sweeps": 12.34, "max_penetration": 1.2e-5,
                "sideways_force": 1.2e-15, "cpu_s": 1234.5, "oscillation": -0.0123, "swap_asymmetry": 0.0123,
                "pressure_error": 0.0123, "reaction_against_pressure": 1.2e-4}  # fmt: skip
        rows = [replace(row, algorithm="node-on-segment", status="not-converged", measures=wide) for row in table.rows]
        text = shown(render(replace(table, rows=rows)), WIDTH)
        assert "CPU" in text
        assert "not shown" not in text
        assert max(map(len, text.splitlines())) <= WIDTH

    def test_a_narrow_terminal_loses_columns_but_no_digits(self, table: Table) -> None:
        text = shown(render(table, 60), 60)
        assert "not shown for lack of width" in text
        assert "…" not in text

    def test_what_is_the_same_in_every_row_goes_first_and_stands_below(self, table: Table) -> None:
        rows = [replace(row, level=2, measures={**row.measures, "reaction": 666.7}) for row in table.rows]
        text = shown(render(replace(table, rows=rows), 60), 60)
        assert "in every row: level 2, reaction 666.7" in " ".join(text.split())
        assert "not shown" not in text

    def test_error_and_cost_are_the_last_to_go(self, table: Table) -> None:
        rows = [replace(row, measures=dict.fromkeys(USUAL, 1.0 + 0.1 * n)) for n, row in enumerate(table.rows)]
        text = shown(render(replace(table, rows=rows), 80), 80)
        assert max(map(len, text.splitlines())) <= 80
        heads = text.split("─")[0]
        assert "p error" in heads
        assert "CPU" in heads
        assert "sideways force" in text.split("not shown for lack of width")[1]

    def test_a_measure_that_no_run_has_is_named_and_not_drawn(self, table: Table) -> None:
        text = " ".join(shown(render(table)).split())
        assert "no run has: reaction vs pressure" in text

    def test_a_pipe_gets_the_whole_table(self, table: Table) -> None:
        file = io.StringIO()
        print_table(table, Console(file=file, width=60))
        assert "CPU" in file.getvalue()

    def test_a_study_may_choose_its_columns(self, table: Table) -> None:
        chosen = replace(table, study=replace(table.study, measures=("steps",)))
        text = shown(render(chosen))
        assert "steps" in text
        assert "reaction" not in text.split("not-converged")[0]

    def test_findings_per_algorithm(self, table: Table) -> None:
        alpha, beta = findings(table)
        assert (alpha.finished, alpha.runs, beta.finished, beta.runs) == (0, 2, 2, 2)
        assert beta.pressure_error == (0.01, 0.03)
        assert span(beta.pressure_error, "%") == "1.0 to 3.0 %"
        assert span((2.0, 2.0), "s") == "2.0 s"


class TestSingleRun:
    @pytest.fixture
    def results(self) -> Results:
        x, p = np.linspace(-1.0, 1.0, 21), np.maximum(0.0, 1.0 - np.linspace(-1.0, 1.0, 21) ** 2)
        zero = np.zeros_like(x)
        curve = ContactCurve(x, x, zero, p, zero, p, zero, np.ones(21, np.int32), np.zeros(21, np.int32))
        summary = {
            "scene": "squeeze", "status": "not-converged", "reason": "it rings",
            "steps": 12000, "contact_sweeps": 30000,
            "resolved": {"ramp": 1e-5, "damping": 2e5}, "reaction_mismatch": 0.01,
            "reactions": {"lower.bottom": [0.0, 99.0], "upper.top": [1e-12, -100.0]},
            "contacts": {"contacts.0": {"resultant": [0.0, 100.0], "pressure_integral": [0.0, 99.5],
                                        "max_pressure": 3.0, "max_penetration": 1e-5, "penetrating_side": "master"}},
            "balance": {"kinetic": 0.002, "stored": 2.0, "internal": 2.0, "external": 2.1, "damping": 0.1,
                        "friction": 0.0, "ledger_error": 1e-13},
            "warnings": [{"code": "slower-loading", "value": 0.02, "limit": 0.01, "key": "time.ramp",
                          "text": "kinetic energy is 2 times the limit; be slower"}],
            "cost": {"run_cpu_s": 2.0, "phases": {"elements": 1.5, "contact": 0.5}, "build_s": 0.1},
        }  # fmt: skip
        history = {"contacts.0": ContactHistory([0.0], [curve])}
        return Results(summary, {}, history, np.zeros((0, 2)), np.zeros((0, 2)), {}, {}, Path("runs/squeeze-001"))

    @pytest.mark.parametrize(
        "words",
        [
            ("squeeze", "not-converged"),
            ("it rings",),
            ("steps", "12 000"),
            ("sweeps per step", "2.5"),
            ("reaction of upper.top", "0  -100", "N/mm"),  # 1e-12 beside 100 is round-off
            ("sum of reactions", "1.0", "%"),
            ("reaction against pressure of contacts.0", "0.50", "%"),
            ("deepest penetration (by the master)", "1.0e-5", "mm"),
            ("mirror asymmetry", "%"),
            ("kinetic over work of stresses", "0.0010"),
            ("energy error: ledger", "1.0e-13"),
            ("CPU time of the steps", "2.00", "s"),
            ("of it elements", "75", "%"),
            ("of it contact", "25", "%"),
            ("damping, chosen", "200000", "1/s"),
            ("warning (slower-loading):", "kinetic energy is 2 times the limit; be slower"),
        ],
    )
    def test_what_a_reader_wants_to_know(self, results: Results, words: tuple[str, ...]) -> None:
        scene = {
            "units": "mm N s t",
            "symmetry": "x",
            "contacts": [{"slave": "upper.bottom", "master": "lower.top"}],
        }
        lines = shown(render_run(results, scene)).splitlines()
        assert any(all(word in line for word in words) for line in lines)


def test_a_comparison_in_which_nothing_finished_says_so_first(table: Table) -> None:
    lost = replace(table, rows=[replace(row, status="failed", reason="out of room") for row in table.rows])
    first = shown(render(lost)).splitlines()[0]
    assert first.startswith(f"not one of {len(lost)} runs came to its end; failed: out of room")
    assert sentence(lost).startswith("Not one of 4 runs")
    assert "not one" not in shown(render(table))
