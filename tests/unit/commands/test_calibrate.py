"""What a new user sees of prices: none yet, wrong words, and a bill in `contactlab explain`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from contactlab.cli import main
from contactlab.commands.explain import effect_price, price_lines
from contactlab.prices import calibrate as calibration
from contactlab.prices import price_list
from contactlab.prices.foreseen import Bill, EffectPrice
from contactlab.prices.price import Price
from contactlab.prices.price_list import PriceList, load_prices, price_file


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CONTACTLAB_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> PriceList:
    """Measuring takes no time."""
    units = {"frame": 1e-3, "element q1: cell": 5e-8, "material linear-elastic: point": 0.0}
    made = PriceList(
        "2026-01-02",
        price_list.machine(),
        price_list.versions(),
        units,
        {"effect wind": "it blew"},
        {"explicit, recorded": 1.5},
        {"explicit, recorded": 200.0},
        1e-4,
    )
    monkeypatch.setattr(calibration, "calibrate", lambda registry, rounds, progress: made)
    return made


def test_prices_are_kept_and_told(quick: PriceList, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate"]) == 0
    told = capsys.readouterr().out
    assert load_prices() == quick
    assert str(price_file()) in told.replace("\n", "")
    assert "no price of effect wind: it blew" in told
    assert "in others" in told


def test_a_broken_file_is_told_and_made_anew(quick: PriceList, capsys: pytest.CaptureFixture[str]) -> None:
    price_file().parent.mkdir(parents=True)
    price_file().write_text("{")
    assert main(["calibrate", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert "broken" in told["replaced"]
    assert told["units"] == quick.units
    assert load_prices() == quick


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--rounds", "0"], "a whole number >= 1"),
        (["--rounds", "many"], "a whole number >= 1"),
        (["--round", "2"], "--rounds"),
        (["disc-on-blok"], "disc-on-block"),
        (["--set", "level=2"], "no scene for --set"),
        (["--with", "nowhere.py"], "nowhere.py"),
    ],
)
def test_wrong_words_are_wrong_requests(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", *words]) == 2
    assert said in capsys.readouterr().err


def test_without_prices_explain_says_what_to_run() -> None:
    from contactlab.commands.explain import foreseen
    from contactlab.scene.scene import load_scene

    (line,) = price_lines(foreseen(load_scene("two-bars")))
    assert line[0] == "price"
    assert "not known" in line[1]
    assert "contactlab calibrate" in line[1]


def test_a_bill_is_told_in_lines() -> None:
    effects = [
        EffectPrice("friction", True, 0.9, 0.6, 1.4, 0.1),
        EffectPrice("inertia", True, reason="refused", refused=True),
        EffectPrice("wind", False, reason="unknown: no price is known for effect wind"),
        EffectPrice("recording", False, -0.01, -0.02, 0.0, 0.1),
    ]
    bill = Bill(Price(7.5, 5.0, 11.0, 3.0, 100.0, ["material clay"]), effects, 1.5, 200.0)
    lines = dict(price_lines(bill))
    assert lines["price"].startswith("9 s of CPU time (6.5 to 12), 7.5 s of them for its steps; 203 MiB")
    assert "without material clay" in lines["price"]
    assert lines["of that"] == "friction: +0.9 s, +12 %"
    assert lines["would cost"] == "wind: unknown: no price is known for effect wind; recording: 0 s"
    assert effect_price(effects[0], 7.5) == "friction: +0.9 s, +12 %"
