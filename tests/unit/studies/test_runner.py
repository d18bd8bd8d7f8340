"""A comparison records every run: what finished, what failed, and what took its process along."""

from __future__ import annotations

import csv
import json
import math
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from inline import runs_inline

import contactlab
from contactlab.comparison import compare
from contactlab.errors import RequestError
from contactlab.jobs import driver
from contactlab.scene.scene import load_scene
from contactlab.studies.table import Table

ALL = {
    "level": [1, 2],
    "contacts.0.algorithm": ["node-on-segment", "mortar-p0"],
    "contacts.0.swap": [False, True],
}


@pytest.mark.usefixtures("fake_runs")
class TestRecording:
    def test_every_run_is_a_row_with_status_and_reason_in_files_and_bars(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        folder = tmp_path / "new" / "out"
        table = compare("disc-on-block", ALL, out=folder, jobs=2, progress=True)
        told = capsys.readouterr().err
        assert "8/8" in told
        assert "mortar-p0-disc-level-2: not-converged" in told
        assert len(table) == 8
        died, raised = table.select(algorithm="node-on-segment", level=1)
        assert (died.slave, died.status) == ("disc", "failed")
        assert "exit status 3" in died.reason
        assert (raised.slave, raised.status) == ("block", "failed")
        assert raised.reason == "ZeroDivisionError: a part divides by nothing"
        assert [row.status for row in table.select(algorithm="mortar-p0", level=1)] == ["finished"] * 2
        unsettled = table.select(algorithm="mortar-p0", level=2)
        assert [(row.status, row.reason) for row in unsettled] == [("not-converged", "it never came to rest")] * 2
        assert len(table.failed) == 6
        self.check_files(folder, table)

    @pytest.mark.full
    def test_the_traceback_is_kept_for_the_author_of_the_part(self, tmp_path: Path) -> None:
        table = compare("disc-on-block", ALL, out=tmp_path, jobs=2)
        (raised,) = table.select(algorithm="node-on-segment", level=1, slave="block")
        assert "in perform" in (tmp_path / "runs" / raised.name / "error.txt").read_text()

    def test_measures_of_single_runs_and_of_pairs(self) -> None:
        table = compare("disc-on-block", ALL | {"level": [1]}, jobs=2)
        row, partner = table.select(algorithm="mortar-p0")
        assert row["steps"] == 100.0
        assert row["sweeps"] == 3.0
        assert row["cpu_s"] == 2.0  # without the first step
        assert row["reaction"] == 50.0
        assert row["reaction_against_pressure"] == pytest.approx(0.01)
        # 0.99 p against 1.01 p, both over the same nodes: S = 2 * 0.02 / 2
        assert row["swap_asymmetry"] == pytest.approx(0.02, rel=1e-9)
        assert partner["swap_asymmetry"] == row["swap_asymmetry"]
        assert row["swap_reaction_difference"] == 0.0
        assert math.isnan(table.select(algorithm="node-on-segment", slave="disc")[0]["swap_asymmetry"])

    def test_a_run_that_stopped_on_the_way_is_shown_but_not_compared(self) -> None:
        vary = {"level": [9], "contacts.0.algorithm": ["mortar-p0"], "contacts.0.swap": [False, True]}
        row, _ = compare("disc-on-block", vary, jobs=1)
        assert (row.status, row.reason) == ("diverged", "it blew up")
        assert row.curve is not None
        assert row["reaction"] == 50.0
        assert math.isnan(row["pressure_error"])
        assert math.isnan(row["swap_asymmetry"])
        assert "before the load was complete" in row["notes"]

    def check_files(self, folder: Path, table: Table) -> None:
        names = {path.name for path in folder.iterdir()}
        plots = {f"{name}.{kind}" for name in ("pressure", "error-against-cost") for kind in ("svg", "png")}
        assert names >= {"table.csv", "table.json", "report.html", "study.toml", "runs"} | plots
        with (folder / "table.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert [(row["algorithm"], row["slave"], row["status"], row["reason"]) for row in rows] == [
            (row.algorithm, row.slave, row.status, row.reason) for row in table
        ]
        assert all(row["processor"] and row["python"] and row["numpy"] for row in rows)
        data = json.loads((folder / "table.json").read_text(), parse_constant=pytest.fail)
        assert [row["status"] for row in data["rows"]] == [row.status for row in table]
        assert data["rows"][0]["reaction"] is None
        assert data["agreement"] == []  # no two algorithms came to the end

    @pytest.mark.full
    def test_a_study_that_was_left_can_be_run_again(self, tmp_path: Path) -> None:
        first = compare("disc-on-block", ALL, out=tmp_path / "a", jobs=2)
        again = compare(tmp_path / "a" / "study.toml", jobs=2)
        assert [row.name for row in again] == [row.name for row in first]

    def test_without_out_nothing_is_written(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        before = set(tmp_path.rglob("*"))
        with pytest.raises(RequestError, match="at least one process"):
            compare("disc-on-block", ALL, jobs=0)
        compare("disc-on-block", {"contacts.0.algorithm": ["node-on-segment"]}, jobs=1)
        assert set(tmp_path.rglob("*")) == before

    def test_results_are_never_overwritten(self, tmp_path: Path) -> None:
        (tmp_path / "table.csv").write_text("precious")
        with pytest.raises(RequestError, match="holds results already"):
            compare("disc-on-block", ALL, out=tmp_path)
        assert (tmp_path / "table.csv").read_text() == "precious"

    def test_an_interrupt_keeps_what_is_done(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        perform = driver.perform

        def interrupted(*call: object) -> bytes:
            os.kill(os.getpid(), signal.SIGINT)
            return perform(*call)

        monkeypatch.setattr(driver, "perform", interrupted)
        monkeypatch.setattr("contactlab.comparison.write_report", lambda *_: None)
        with pytest.raises(KeyboardInterrupt):
            compare("disc-on-block", {"contacts.0.swap": [False, True], "level": [1, 3, 4, 5]}, out=tmp_path, jobs=1)
        with (tmp_path / "table.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        statuses = [row["status"] for row in rows]
        assert len(statuses) == 8
        assert "finished" in statuses
        assert "interrupted" in statuses


@pytest.mark.usefixtures("fake_runs")
class TestReferences:
    def test_a_reference_serves_the_rows_that_it_holds_for(self) -> None:
        vary = {"contacts.0.algorithm": ["mortar-p0"], "supports.1.uy.to": [-0.01, -0.02]}
        shallow, other = compare(load_scene("disc-on-block"), vary, jobs=1)
        assert shallow.reference == "disc-on-block-shallow"
        assert shallow["pressure_error"] > 0.0
        assert other.reference == ""
        assert math.isnan(other["pressure_error"])
        assert other.notes

    def test_a_named_reference_that_does_not_hold_is_noted_with_the_key(self, tmp_path: Path) -> None:
        study = tmp_path / "s.toml"
        study.write_text(
            'scene = "disc-on-block"\nreference = "disc-on-block-shallow"\n[vary]\n'
            '"contacts.0.algorithm" = ["mortar-p0"]\n"materials.soft.young" = [7100.0]\n"supports.1.uy.to" = [-0.01]\n'
        )
        (row,) = compare(study, jobs=1)
        assert "materials.soft.young is 7100.0" in row.notes[0]

    def test_an_unknown_reference_is_a_wrong_request(self, tmp_path: Path) -> None:
        study = tmp_path / "s.toml"
        study.write_text('scene = "disc-on-block"\nreference = "disc-on-block-shalow"\n')
        with pytest.raises(RequestError, match="no such reference") as caught:
            compare(study, jobs=1)
        assert "disc-on-block-shallow" in str(caught.value)


# some hundred steps: enough to touch
QUICK = {"time.end": 2e-6, "time.ramp": 1e-5, "record.recorders": ["vtkhdf"], "record.frames": 4}


@pytest.mark.full
def test_real_runs_and_what_only_the_model_refuses_give_rows(tmp_path: Path) -> None:
    scene = load_scene("disc-on-block").with_(QUICK)
    vary = {"contacts.0.master": ["block.top", "block.roof"]}
    with runs_inline():
        table = contactlab.compare(scene, vary, out=tmp_path, jobs=1)
    assert [row.status for row in table] == ["finished", "refused"]
    for row in table.rows[1::2]:
        assert "block.roof" in row.reason
        assert "block.top" in row.reason
    for row in table.rows[::2]:
        assert row.status == "finished"
        assert row["steps"] > 100
        assert row["reaction"] > 0.0
        assert (tmp_path / "runs" / row.name / "contact.csv").is_file()
        assert set(row.shapes) == {"disc", "block"}
    assert (tmp_path / "bodies.png").is_file()


@pytest.mark.full
def test_repeated_runs_report_the_median_cost(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(load_scene("disc-on-block").with_(QUICK).toml())
    (tmp_path / "study.toml").write_text('scene = "scene.toml"\nrepeat = 3\n[vary]\nlevel = [1]\n')
    (row,) = compare(tmp_path / "study.toml", jobs=1)
    assert row.status == "finished"
    assert row["cpu_s"] > 0.0


@pytest.mark.full
def test_a_script_needs_no_guard(tmp_path: Path, fake_source: str) -> None:
    (tmp_path / "fake_runs.py").write_text(fake_source)
    script = tmp_path / "script.py"
    script.write_text(
        textwrap.dedent("""
        import fake_runs, contactlab
        from contactlab.jobs import driver
        driver.perform = fake_runs.perform
        scene = contactlab.load_scene("disc-on-block")
        table = contactlab.compare(scene, vary={"contacts.0.algorithm": ["mortar-p0"]}, out="out", jobs=2)
        print(table["status"])
        """)
    )
    done = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "['finished']", done.stderr


def test_the_function_is_that_of_the_front_page_whatever_was_imported_before() -> None:
    import contactlab.studies.table

    with pytest.raises(RequestError, match="no such scene"):
        contactlab.compare("no-such-scene")
