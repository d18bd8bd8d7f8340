"""How far a case can be driven."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from inline import runs_inline

from contactlab.cli import main
from contactlab.verdicts.margins import HALVINGS, bisection


def bisected(holds: Callable[[float], bool], start: float, limit: float) -> tuple[float, float]:
    search = bisection(start, limit)
    value = next(search)
    while True:
        try:
            value = search.send(holds(value))
        except StopIteration as end:
            return end.value  # type: ignore[no-any-return]


@pytest.mark.parametrize("edge", [1.5, 3.0, 9.9])
def test_the_edge_is_enclosed(edge: float) -> None:
    seen: list[float] = []

    def holds(value: float) -> bool:
        seen.append(value)
        return value <= edge

    good, bad = bisected(holds, 1.0, 10.0)
    assert good <= edge < bad
    assert math.log(bad / good) == pytest.approx(math.log(10.0) / 2**HALVINGS)
    assert len(seen) == HALVINGS + 2


def test_from_zero_and_downwards() -> None:
    good, bad = bisected(lambda value: value <= 0.3, 0.0, 1.0)
    assert good <= 0.3 < bad
    good, bad = bisected(lambda value: value >= 0.3, 1.0, 0.01)
    assert bad < 0.3 <= good


def test_never_and_always() -> None:
    never, always = (bisected(lambda value, answer=answer: answer, 1.0, 2.0) for answer in (False, True))
    assert math.isnan(never[0])
    assert never[1] == 1.0
    assert always[0] == 2.0
    assert math.isnan(always[1])


@pytest.mark.full
def test_the_command_writes_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The frictional block keeps its place up to the limit, whatever its friction."""
    words = [
        "matrix",
        "pulled-block",
        "--contact",
        "mortar-p1",
        "--margins",
        "--jobs",
        "1",
        "--out",
        str(tmp_path / "m"),
    ]
    with runs_inline():
        assert main(words) == 0
    (line,) = (tmp_path / "m" / "margins.csv").read_text().splitlines()[1:]
    assert line.startswith("pulled-block,mu,mortar-p1,1.0,100.0,")
    assert "pulled-block" in capsys.readouterr().out
