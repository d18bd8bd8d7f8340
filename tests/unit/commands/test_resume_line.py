"""The command that an interrupted one is resumed with, and commands that make a run of their own."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from contactlab.accuracy.answer import Tried
from contactlab.accuracy.choose import Chosen
from contactlab.commands import choose as chooses
from contactlab.commands.arguments import make_parser
from contactlab.commands.common import resume_line
from contactlab.results.load import load_results


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("run disc-on-block --set level=2", "run disc-on-block --set level=2"),
        ("matrix patch hertz --jobs 1 --out there", "matrix patch hertz --jobs 1"),
        ("choose a.toml --out=there --resume --error 1%", "choose a.toml --error 1%"),
        ("compare s --vary level=[1,2] --resume --out x --keep none", "compare s --vary 'level=[1,2]' --keep none"),
    ],
)
def test_every_word_is_kept_but_the_folder(words: str, line: str) -> None:
    options = make_parser().read(words.split())
    assert resume_line(options, Path("runs/it")) == f"contactlab {line} --out runs/it --resume"


def test_the_choice_is_run_as_the_command_that_is_printed(tmp_path: Path) -> None:
    """`choose --run` ended in an AttributeError after the search, however long that took."""
    short = ["--set", "time.end=1e-8", "--set", "supports.1.uy.to=-1e-5"]
    options = make_parser().read(["choose", "disc-on-block", *short, "--run"])
    found = cast("Chosen", SimpleNamespace(choice={"contacts.0.algorithm": "mortar-p1", "contacts.0.swap": True}))
    assert chooses._run(options, found, tmp_path / "run") == 0
    results = load_results(tmp_path / "run")
    assert results.status == "finished"
    assert results.layout.contacts[0].slave == "block.top"


def test_trials_with_the_error_come_first_the_cheapest_before_others() -> None:
    def trial(name: str, error: float, *cpu_s: float) -> Tried:
        return Tried(name, 1, "finished", "", error, cpu_s)

    trials = [trial("none", math.nan), trial("far", 0.5, 0.1), trial("slow", 0.001, 3.0), trial("near", 0.02, 0.2),
              trial("fast", 0.009, 1.0, 9.0, 2.0)]  # fmt: skip
    assert [one.configuration for one in chooses.best_first(trials, 0.01)] == ["fast", "slow", "near", "far", "none"]
