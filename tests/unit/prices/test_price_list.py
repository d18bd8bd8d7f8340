"""Prices are kept by machine and version; what cannot be used is said plainly."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from contactlab.errors import RequestError
from contactlab.prices import price_list
from contactlab.prices.price_list import NoPricesError, PriceList, load_prices, price_file, store_prices

STARTS = {"explicit": 1.0, "explicit, recorded": 1.5}
MEMORY = {"explicit": 150.0, "explicit, recorded": 200.0}


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("CONTACTLAB_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def some_prices() -> PriceList:
    return PriceList(
        "2026-01-02", price_list.machine(), price_list.versions(), {"frame": 1e-3}, {}, STARTS, MEMORY, 1e-4
    )


def test_what_is_stored_is_loaded_again(cache: Path) -> None:
    file = store_prices(some_prices())
    assert file.parent == cache / "prices"
    assert load_prices() == some_prices()
    assert not list(file.parent.glob("*.part"))


def test_the_file_is_named_by_machine_and_versions(monkeypatch: pytest.MonkeyPatch) -> None:
    here = price_file().name
    for library, number in price_list.versions().items():
        assert f"{library}-{number}" in here
    monkeypatch.setattr(price_list, "version", lambda name: "9.9")
    assert price_file().name != here
    monkeypatch.undo()
    monkeypatch.setattr(price_list, "processor_name", lambda: "Another (R)/CPU")
    assert price_file().name.startswith("Another-R-CPU-")


def test_prices_of_another_version_are_not_used_but_told(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(NoPricesError, match="not measured yet") as none:
        load_prices()
    assert "contactlab calibrate" in str(none.value)
    store_prices(some_prices())
    monkeypatch.setattr(price_list, "version", lambda name: "9.9")
    with pytest.raises(NoPricesError, match="1 of other versions or machines"):
        load_prices()


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        '{"format": 7}',
        json.dumps({"format": 1, "units": {}}),
        json.dumps(vars(replace(some_prices(), units={"frame": "dear"}))),
        json.dumps(vars(replace(some_prices(), units={"frame": float("nan")}))),
        json.dumps(vars(replace(some_prices(), units={}))),
    ],
)
def test_a_broken_file_is_called_broken_and_can_be_replaced(text: str) -> None:
    file = store_prices(some_prices())
    file.write_text(text)
    with pytest.raises(NoPricesError, match="broken") as broken:
        load_prices()
    assert str(file) in str(broken.value)
    store_prices(some_prices())
    assert load_prices() == some_prices()


def test_bytes_that_are_no_text_are_no_prices() -> None:
    store_prices(some_prices()).write_bytes(b"\xff\xfe\x00")
    with pytest.raises(NoPricesError, match="cannot be read"):
        load_prices()


def test_a_folder_that_cannot_be_made_is_a_wrong_request(cache: Path) -> None:
    cache.write_text("a file where the folder should be")
    with pytest.raises(RequestError, match="cannot be kept"):
        store_prices(some_prices())
