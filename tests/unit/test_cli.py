"""The program: what it prints, what it leaves, and the exit status it returns."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

import contactlab
from contactlab.cli import _worded, main
from contactlab.errors import ContactlabWarning
from contactlab.parts.machine import blas_kernels
from contactlab.parts.registry import Registry
from contactlab.run.folders import fresh_folder, results_folder

QUICK = ["--set", "time.end=2e-7", "--set", "bodies.disc.mesh.cells=[8, 2]", "--set", "bodies.block.mesh.cells=[12, 2]"]

PART = """
from dataclasses import dataclass
from contactlab.api import MeshSource
from contactlab.api.plugin import Part, hookimpl

@dataclass(frozen=True)
class Strip(MeshSource):
    \"\"\"A rectangle of the core under another name.\"\"\"

    height: float

    def mesh(self, element, level):
        from contactlab.meshing import Rectangle

        return Rectangle((-0.9, 0.9), (-self.height, 0.0), (12, 2)).mesh(element, level)

@hookimpl
def contactlab_parts():
    return [Part("mesh", "strip", "strip_part:Strip", "for tests")]
"""


@pytest.fixture
def in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def run_here(in_folder: Path) -> Callable[..., int]:
    return lambda *more: main(["run", "disc-on-block", *QUICK, *more])


class TestRun:
    def test_a_run_leaves_its_files_in_a_fresh_numbered_folder(
        self, run_here: Callable[..., int], capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert run_here() == 0
        assert run_here() == 0
        shown = capsys.readouterr()
        assert "results in runs/disc-on-block-001" in shown.out
        assert "results in runs/disc-on-block-002" in shown.out
        assert "finished" in shown.out
        assert "peak force" in shown.out
        for number in ("001", "002"):
            left = {path.name for path in Path(f"runs/disc-on-block-{number}").iterdir()}
            assert {"scene.toml", "summary.json", "contact.csv", "history.csv"} <= left

    def test_the_scene_it_leaves_reproduces_the_run(self, run_here: Callable[..., int]) -> None:
        """Bit for bit: all settings are written out and the computation has no chance in it."""
        run_here("--out", "first")
        assert main(["run", "first/scene.toml", "--out", "second"]) == 0
        for name in ("scene.toml", "history.csv", "contact.csv"):
            assert Path("first", name).read_bytes() == Path("second", name).read_bytes()

    def test_for_programs(self, run_here: Callable[..., int], capsys: pytest.CaptureFixture[str]) -> None:
        assert run_here("--json", "--out", "out") == 0
        assert json.loads(capsys.readouterr().out) == {
            "folder": "out",
            **json.loads(Path("out/summary.json").read_text()),
        }

    def test_settings_reach_the_run(self, run_here: Callable[..., int]) -> None:
        run_here("--out", "out", "--set", "contacts.0.algorithm=mortar-p1", "--set", "contacts.0.swap=true")
        summary = json.loads(Path("out/summary.json").read_text())
        assert summary["status"] == "finished"
        assert "mortar-p1" in summary["parts"]["contacts.0.algorithm"]
        with Path("out/contact.csv").open() as file:
            assert len(list(csv.DictReader(file))) == 13  # nodes of the block's top, now the slave

    @pytest.mark.full
    def test_a_simulation_that_fails_returns_1_and_keeps_what_it_has(
        self, in_folder: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        diverging = ["run", "vertex-to-vertex", "--set", "contacts.0.algorithm=node-on-segment"]
        diverging += ["--set", "integrator.forces=frozen"]
        assert main([*diverging, "--out", "out"]) == 1
        summary = json.loads(Path("out/summary.json").read_text())
        assert summary["status"] == "diverged"
        assert summary["reason"]
        assert "diverged" in capsys.readouterr().out

    def test_an_interrupt_returns_130(
        self, run_here: Callable[..., int], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        def stop(*args: object, **more: object) -> None:
            raise KeyboardInterrupt

        monkeypatch.setattr("contactlab.run.simulation.simulate", stop)
        assert run_here() == 130
        assert "interrupted" in capsys.readouterr().err
        assert not Path("runs/disc-on-block-001").exists()

    @pytest.mark.parametrize(("status", "code"), [("refused", 2), ("interrupted", 130), ("not-converged", 1)])
    def test_the_exit_status_follows_the_status_of_the_run(self, status: str, code: int) -> None:
        from contactlab.commands.run import EXIT_STATUS

        assert EXIT_STATUS.get(status, 1) == code

    @pytest.mark.full
    def test_parts_in_a_file(self, in_folder: Path) -> None:
        Path("strip_part.py").write_text(PART)
        mesh = "bodies.block.mesh={use=strip, height=0.3}"
        try:
            words = ["run", "disc-on-block", "--with", "strip_part.py", "--set", mesh, "--set", "time.end=2e-7"]
            assert main([*words, "--out", "out"]) == 0
        finally:
            sys.modules.pop("strip_part", None)
        assert "strip" in Path("out/scene.toml").read_text()


class TestListings:
    def test_a_broken_scene_of_a_plugin_is_a_row(
        self, in_folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        Path("odd.toml").write_text("[broken")
        monkeypatch.setattr(Registry, "scenes", lambda self: {"odd": Path("odd.toml"), "gone": Path("gone.toml")})
        assert main(["scenes"]) == 0
        shown = capsys.readouterr().out
        assert shown.count("broken: ") == 2
        assert "disc-on-block" in shown


class TestDoctor:
    def test_a_contact_step_works(self, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("COLUMNS", "400")
        assert main(["doctor"]) == 0
        shown = capsys.readouterr().out
        for word in ("works", "numba", "cores", "threads", "contactlab-mortar", blas_kernels()):
            assert word in shown

    def test_a_broken_installation_returns_1(
        self, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("contactlab.commands.doctor.default_registry", lambda: Registry(entry_points=[]))
        assert main(["doctor"]) == 1
        assert "not possible" in capsys.readouterr().out


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["--version"])
    assert left.value.code == 0
    assert capsys.readouterr().out == f"contactlab {contactlab.__version__}\n"


def test_a_command_of_a_plugin(monkeypatch: pytest.MonkeyPatch, in_folder: Path) -> None:
    (in_folder / "greeting.py").write_text("def greet(words):\n    return len(words)\n")
    monkeypatch.syspath_prepend(str(in_folder))
    origin = Registry().parts()[0].origin
    monkeypatch.setattr(Registry, "commands", lambda self: {"greet": ("greeting:greet", origin)})
    assert main(["greet", "a", "--b"]) == 2
    sys.modules.pop("greeting")


class TestFolders:
    @pytest.fixture(autouse=True)
    def _here(self, in_folder: Path) -> None:
        pass

    def test_numbers_count_up_and_names_become_plain(self) -> None:
        assert [fresh_folder("a b/../c").name for _ in range(3)] == ["a-b-..-c-001", "a-b-..-c-002", "a-b-..-c-003"]
        assert fresh_folder("..").parent == Path("runs")

    def test_an_empty_folder_is_taken_away_after_an_error(self) -> None:
        with pytest.raises(ZeroDivisionError), results_folder("out", "x"):
            1 / 0  # noqa: B018
        assert not Path("out").exists()

    def test_what_was_written_stays(self) -> None:
        def fails_later() -> None:
            with results_folder("out", "x") as folder:
                (folder / "history.csv").write_text("")
                raise ValueError

        with pytest.raises(ValueError):
            fails_later()
        assert Path("out/history.csv").exists()


def test_names_of_the_package_are_lazy_and_complete() -> None:
    assert set(contactlab.__all__) <= set(dir(contactlab))
    for name in contactlab.__all__:
        assert getattr(contactlab, name) is not None
    with pytest.raises(AttributeError, match="no_such_name"):
        contactlab.no_such_name  # noqa: B018


def test_warnings_of_the_program_name_no_line_of_its_code() -> None:
    worded = _worded(warnings.formatwarning)
    assert worded(ContactlabWarning("the disk is full"), ContactlabWarning, "run.py", 7) == (
        "contactlab: warning: the disk is full\n"
    )
    assert "part.py:7" in worded(RuntimeWarning("overflow"), RuntimeWarning, "part.py", 7)


@pytest.mark.parametrize("call", ["main()", "main(['--version'])"])
def test_only_the_program_leaves_what_was_imported_to_the_system_when_it_ends(call: str) -> None:
    """Who calls it from a program of his own keeps his garbage collector as it is."""
    program = (
        "import atexit, gc, sys\n"
        "atexit.register(lambda: print(gc.get_freeze_count() > 0, gc.get_threshold()[0] > 100_000))\n"
        "from contactlab.cli import main\n"
        f"sys.argv = ['contactlab', '--version']\n{call}\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1] == ("True True" if call == "main()" else "False False"), done.stderr
