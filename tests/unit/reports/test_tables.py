"""Tables on a terminal: everything in them, and they fit."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from rich.progress import Progress

from contactlab.api import RunWarning
from contactlab.api.drawing.units import Units
from contactlab.api.frame import ContactLayout, Layout
from contactlab.commands.run import progress_columns
from contactlab.reports.findings import findings, sentence, span
from contactlab.reports.numbers import significant, uncertain
from contactlab.reports.run import render_run
from contactlab.reports.run_details import render_details
from contactlab.reports.sheet import Column, Sheet
from contactlab.reports.table import USUAL, every_number, render
from contactlab.results.results import ContactCurve, ContactHistory, Results
from contactlab.studies.table import Row, Table

WIDTH = 140
"""Columns of text that the usual table needs."""


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

    def test_a_narrow_terminal_loses_columns_but_no_digits(self, table: Table) -> None:
        text = shown(render(table), 60)
        assert "not shown for lack of width" in text
        assert "…" not in text

    def test_what_is_the_same_in_every_row_goes_first_and_stands_below(self, table: Table) -> None:
        rows = [replace(row, level=2, measures={**row.measures, "reaction": 666.7}) for row in table.rows]
        text = shown(render(replace(table, rows=rows)), 60)
        assert "in every row: level 2, reaction 666.7" in " ".join(text.split())
        assert "not shown" not in text

    def test_error_and_cost_are_the_last_to_go(self, table: Table) -> None:
        rows = [replace(row, measures=dict.fromkeys(USUAL, 1.0 + 0.1 * n)) for n, row in enumerate(table.rows)]
        text = shown(render(replace(table, rows=rows)), 80)
        assert max(map(len, text.splitlines())) <= 80
        heads = text.split("─")[0]
        assert "p error" in heads
        assert "CPU" in heads
        assert "sideways force" in text.split("not shown for lack of width")[1]

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


class TestNarrowTerminal:
    def test_no_word_or_number_is_cut_while_the_columns_have_room(self) -> None:
        """Words of 11, 16 and 9 characters, and two spaces a column: 42; the long texts are folded between words."""
        rows = [["interrupted", "level=[1, 2, 3], time.end=2.5e-06", "met 6.1e-13"]]
        text = shown(Sheet(["status", "changed", "mortar-p1 + nitsche"], rows), 42)
        assert max(map(len, text.splitlines())) <= 42
        assert {"interrupted", "time.end=2.5e-06", "6.1e-13"} <= set(text.split())

    def test_words_break_behind_hyphens_between_letters_and_nowhere_else(self) -> None:
        text = shown(Sheet(["integrator", "value"], [["central-difference", "-1.5e-10 to -7"]]), 24)
        assert [line.split() for line in text.splitlines() if "-" in line] == [
            ["central-", "-1.5e-10"], ["difference", "to", "-7"],
        ]  # fmt: skip

    def test_a_table_that_is_too_wide_is_drawn_in_parts_behind_the_columns_that_lead(self) -> None:
        names = [f"algorithm{k}" for k in range(5)]
        heads = [Column("case", leads=True, keep=True), *(Column(name, keep=True) for name in names)]
        text = shown(Sheet(heads, [["patch", *(f"{k}.{k}e-13" for k in range(5))]]), 40)
        assert max(map(len, text.splitlines())) <= 40
        assert [line.split() for line in text.splitlines() if "case" in line] == [
            ["case", "algorithm0", "algorithm1"], ["case", "algorithm2", "algorithm3"], ["case", "algorithm4"],
        ]  # fmt: skip
        assert text.split().count("patch") == 3

    @pytest.mark.parametrize("name", ["disc", "disc-on-block", "a-name-that-is-far-too-long-for-any-terminal"])
    @pytest.mark.parametrize("width", [80, 100, 140])
    def test_the_bar_of_a_run_shows_all_its_words(self, name: str, width: int) -> None:
        progress = Progress(*progress_columns(name, width), console=Console(file=io.StringIO(), width=width))
        progress.add_task("100 %  step 123456  t 2.86e-06  energy error 1e-15", total=1.0, completed=0.5)
        (line,) = shown(progress.get_renderable(), width).splitlines()
        assert "energy error 1e-15 0:00:00" in line
        assert line.startswith(name[:10])
        assert "\N{HORIZONTAL ELLIPSIS}" not in line


SCENE = {"units": "mm N s t", "symmetry": "x", "contacts": [{"slave": "upper.bottom", "master": "lower.top"}],
         "supports": [{"on": "upper.top", "uy": {"to": -0.1}}]}  # fmt: skip


class TestSingleRun:
    @pytest.fixture
    def results(self) -> Results:
        x, p = np.linspace(-1.0, 1.0, 21), np.maximum(0.0, 1.0 - np.linspace(-1.0, 1.0, 21) ** 2)
        zero = np.zeros_like(x)
        curve = ContactCurve(x, x, zero, p, zero, p, zero, np.ones(21, np.int32), np.zeros(21, np.int32))
        summary = {
            "scene": "squeeze", "status": "not-converged", "reason": "it rings",
            "steps": 12000, "contact_sweeps": 30000, "reached": {"time": 0.5, "share": 0.5, "of": "load"},
            "resolved": {"ramp": 1e-5, "damping": 2e5}, "reaction_mismatch": 0.01,
            "reactions": {"lower.bottom": [0.0, 99.0], "upper.top": [1e-12, -100.0]},
            "contacts": {"contacts.0": {"resultant": [0.0, 100.0], "pressure_integral": [0.0, 99.5],
                                        "max_pressure": 3.0, "max_penetration": 1e-5, "penetrating_side": "master"}},
            "peaks": {"reactions": {"upper.top": {"value": 130.0, "vector": [0.0, -130.0], "step": 7000, "time": 0.33,
                                                  "share": 0.331}},
                      "contacts": {"contacts.0": {"pressure": {"value": 3.5, "step": 12000, "time": 0.5, "share": 0.5},
                                                  "force": {"value": 130.0, "step": 7000}}}},
            "balance": {"kinetic": 0.002, "stored": 2.0, "internal": 2.0, "external": 2.1, "damping": 0.1,
                        "friction": 0.0, "ledger_error": 1e-13},
            "warnings": [{"code": "slower-loading", "value": 0.02, "limit": 0.01, "key": "time.ramp",
                          "text": "kinetic energy is 2 times the limit; be slower"}],
            "cost": {"run_cpu_s": 2.0, "run_wall_s": 2.5, "phases": {"elements": 1.5, "contact": 0.5}, "build_s": 0.1},
        }  # fmt: skip
        history = {"contacts.0": ContactHistory([0.0], [curve])}
        no_nodes = np.zeros(0, np.int32)
        contact = ContactLayout("contacts.0", "contacts.0", "mortar-p0", "upper.bottom", "lower.top", "",
                                no_nodes, no_nodes, no_nodes, no_nodes)  # fmt: skip
        layout = Layout(
            "", "squeeze", "mm N s t", np.zeros((0, 2)), (), (contact,), ("upper.top",), {}, {}, (), False, 1
        )
        empty = np.zeros((0, 2))
        return Results(summary, layout, history, history, empty, empty, {}, {}, folder=Path("runs/squeeze-001"))

    def test_a_peak_at_the_end_has_one_value(self, results: Results) -> None:
        """The last step of an interrupted run may have a higher pressure than the mean that its last frame stores."""
        results.summary["contacts"]["contacts.0"]["max_pressure"] = 90.0
        results.summary["peaks"]["contacts"] = {"contacts.0": {"pressure": {"value": 100.0, "step": 9000, "time": 0.5}}}
        results.summary["steps"] = 9000
        text = " ".join(shown(render_run(results, SCENE)).split())
        assert "peak pressure 100.00 MPa, upper.bottom on lower.top, at the end peak force" in text

    @pytest.mark.parametrize(("share", "text"), [(-3e-7, "less than 0.01% of"), (0.034, "3.40% of")])
    def test_stabilisation_without_work_is_no_negative_zero(self, results: Results, share: float, text: str) -> None:
        results.summary["stabilisation"] = {"steps": 2.0, "share": share}
        assert f"2 steps; stabilisation took {text} the work" in shown(render_run(results, SCENE))

    def test_of_many_contacts_the_highest_is_shown(self, results: Results) -> None:
        peaks = {f"contacts.{k}": {"pressure": {"value": 1.0 + k % 3, "step": 3, "share": 0.2}} for k in range(6)}
        contacts = [replace(results.layout.contacts[0], name=name, label=name, slave=f"b{name}") for name in peaks]
        results.layout = replace(results.layout, contacts=tuple(contacts))
        results.summary["peaks"]["contacts"] = peaks
        (line,) = (line for line in shown(render_run(results, SCENE)).splitlines() if "pressure" in line)
        assert "3.0000 MPa, bcontacts.2 on lower.top, at 20 % of the load (highest of 6 contacts)" in line

    @pytest.mark.parametrize(
        "words",
        [
            ("steps", "12 000"),
            ("Gauss-Seidel iterations per step", "2.5"),
            ("reaction of upper.top", "0  -100", "N/mm"),  # 1e-12 beside 100 is round-off
            ("peak, at 33 % of the load", "0  -130", "N/mm"),
            ("force imbalance", "1.0", "%"),
            ("reaction vs pressure of contacts.0", "0.50", "%"),
            ("max penetration, by the master", "1.0e-5", "mm"),
            ("mirror asymmetry", "%"),
            ("kinetic / work of stresses", "0.0010"),
            ("error of the energy balance", "1.0e-13"),
            ("CPU time of the steps", "2.00", "s"),
            ("elements", "75", "%"),
            ("contact", "25", "%"),
            ("time.damping, chosen", "200000", "1/s"),
        ],
    )
    def test_all_else_on_request(self, results: Results, words: tuple[str, ...]) -> None:
        lines = shown(render_details(results, SCENE, verbose=True, profile=True), 80).splitlines()
        assert any(all(word in line for word in words) for line in lines)


def test_a_comparison_in_which_nothing_finished_says_so_first(table: Table) -> None:
    lost = replace(table, rows=[replace(row, status="failed", reason="out of room") for row in table.rows])
    first = shown(render(lost)).splitlines()[0]
    assert first.startswith(f"none of {len(lost)} runs finished")
    assert sentence(lost).startswith("None of 4 runs")
    assert "none of" not in shown(render(table))


def test_runs_that_failed_alike_are_one_line(table: Table) -> None:
    reasons = [
        f"Stopped at {k + 60} % of the load, near (20.{k}, -0.4): stuck; try swap = {k % 2 > 0}" for k in range(6)
    ]
    rows = [replace(row, status="not-converged", reason=text) for row, text in zip(table.rows, reasons, strict=True)]
    text = " ".join(shown(render(replace(table, rows=rows))).split())
    assert text.count("stuck") == 1
    assert (
        "¹ 6 runs alike (alpha, beta), not-converged; alpha, slave disc, level 2: Stopped at 60 % of the load" in text
    )
    other = [*rows[:-1], replace(rows[-1], reason="the process was killed by SIGKILL")]
    text = " ".join(shown(render(replace(table, rows=other))).split())
    assert "¹ 5 runs alike" in text
    assert "² beta, slave block, level 4, not-converged: the process was killed" in text


def test_all_numbers_of_a_comparison_fit_a_narrow_terminal(table: Table) -> None:
    text = shown(every_number(table, 80), 80)
    assert max(map(len, text.splitlines())) <= 80
    for column in ("reaction", "pressure error", "CPU", "steps"):
        assert any(line.strip().startswith(f"{column} ") for line in text.splitlines())
    for row in table.failed:
        assert row.reason in " ".join(text.split())
