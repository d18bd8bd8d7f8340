"""The commands as functions: public names stay what they are, results are objects, wrong requests are refused."""

from __future__ import annotations

import subprocess
import sys
import typing
from pathlib import Path

import pytest
from inline import runs_inline

import contactlab
from contactlab.cli import main
from contactlab.commands.matrix import show
from contactlab.errors import RequestError

AFTER_ALL = """
import importlib, pkgutil, types, contactlab
for module in pkgutil.walk_packages(contactlab.__path__, "contactlab."):
    if not module.name.endswith("__main__") and ".data." not in module.name:
        try:
            importlib.import_module(module.name)
        except ImportError:
            pass
print([name for name in contactlab.__all__ if isinstance(getattr(contactlab, name), types.ModuleType)], dir(contactlab))
"""


@pytest.mark.full
def test_no_submodule_takes_the_place_of_a_public_name() -> None:
    done = subprocess.run([sys.executable, "-c", AFTER_ALL], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == f"[] {sorted(contactlab.__all__)}"


@pytest.mark.parametrize(
    "name", ["check", "choose", "compare", "error_budget", "explain", "load_table", "matrix", "simulate"]
)
def test_functions_say_what_they_return(name: str) -> None:
    returned = typing.get_type_hints(getattr(contactlab, name))["return"]
    assert returned is not typing.Any


def test_a_part_is_checked() -> None:
    (report,) = contactlab.check("coulomb", only=["numbers_in_range"])
    assert report.right
    assert report.outcomes[-1].check == "numbers_in_range"


def test_a_matrix_is_judged_and_found_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with runs_inline():
        first = contactlab.matrix(["two-bars"], ["mortar-p0", "node-on-segment"], out=tmp_path / "matrix", jobs=1)
    assert first.count("met") == len(first.cells) == 2
    assert {path.name for path in (tmp_path / "matrix").iterdir()} >= {"matrix.csv", "matrix.json", "matrix.html"}
    scenes = {path.stem for path in (tmp_path / "matrix/scenes").iterdir()}
    assert scenes == {key for _, result in first.cells for key in result.runs}
    show(first)
    printed = " ".join(capsys.readouterr().out.split())
    for _, result in first.cells:
        assert any(f"met {m['value']:.2g}" in printed for m in result.measures)
    assert "met: all measures are within their limits" in printed
    again = contactlab.matrix(["two-bars"], ["mortar-p0", "node-on-segment"], out=tmp_path / "matrix", resume=True)
    assert [result.measures for _, result in again.cells] == [result.measures for _, result in first.cells]


@pytest.mark.full
def test_a_choice_is_made_of_keys_that_a_run_takes(tmp_path: Path) -> None:
    """Every finer mesh of the bars is refused, so that no error can be measured: there is a choice all the same."""
    with runs_inline():
        found = contactlab.choose("two-bars", 0.05, search=5.0, jobs=1)
    assert found.verdict == "cannot"
    assert found.error_interval is None
    assert "no configuration finished on two meshes" in found.why
    words = [word for key, value in found.choice.items() for word in ("--set", f"{key}={value}")]
    assert main(["run", "two-bars", *words, "--out", str(tmp_path / "run")]) == 0


@pytest.mark.parametrize(
    ("call", "where"),
    [
        (lambda: contactlab.choose("two-bars", "1 %"), "choose, argument error"),  # type: ignore[arg-type]
        (lambda: contactlab.error_budget("two-bars", resume=True), "resume"),
        (lambda: contactlab.error_budget(7), "error_budget, argument scene"),  # type: ignore[arg-type]
        (lambda: contactlab.check(["coulomb"]), "check, argument target"),  # type: ignore[arg-type]
    ],
)
def test_wrong_requests_name_the_argument(call: typing.Callable[[], object], where: str) -> None:
    with pytest.raises(RequestError) as refused:
        call()
    assert refused.value.where == where
