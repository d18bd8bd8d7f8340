"""`contactlab calibrate`: the prices of this machine, from which `contactlab explain` foresees what runs will cost."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from contactlab.commands.common import add_row, console, print_json, registry_with, table
from contactlab.errors import RequestError

if TYPE_CHECKING:
    from contactlab.prices.calibrate import Progress
    from contactlab.prices.price_list import PriceList


def calibrate(options: argparse.Namespace) -> int:
    """Measure the prices of all parts and keep them; those that were there are replaced."""
    from contactlab.prices.calibrate import calibrate as prices_of
    from contactlab.prices.price_list import store_prices

    registry = registry_with(options.files)
    replaced = _replaced()
    with _told() as progress:
        prices = prices_of(registry, options.rounds, progress)
    file = store_prices(prices)
    if options.json:
        print_json({"format": 1, "file": str(file), "replaced": replaced, **_plain(prices)})
        return 0
    out = console()
    out.print(_table(prices))
    for part, reason in prices.unknown.items():
        out.print(f"no price of {part}: {reason}", markup=False, highlight=False, soft_wrap=True)
    if replaced:
        out.print(replaced, markup=False, highlight=False, soft_wrap=True)
    out.print(f"kept in {file}", markup=False, highlight=False, soft_wrap=True)
    return 0


def _replaced() -> str:
    """What is said of a file that was there and is of no use; nothing where none was."""
    from contactlab.prices.price_list import load_prices, price_file

    try:
        load_prices()
    except RequestError as error:
        return f"made anew: {error}" if price_file().exists() else ""
    return ""


def _plain(prices: PriceList) -> dict[str, object]:
    return {name: getattr(prices, name) for name in prices.__dataclass_fields__ if name != "format"}


def _table(prices: PriceList) -> object:
    """A row for each unit: its price in microseconds."""
    shown = table("of", "each", "CPU µs", title=f"prices of {prices.machine}, {prices.made}")
    for unit, price in prices.units.items():
        part, _, what = unit.partition(": ")
        add_row(shown, part, what, f"{1e6 * price:.3g}" if price else "in others")
    return shown


@contextmanager
def _told() -> Iterator[Progress | None]:
    """A line on the terminal that says what is measured; nothing where there is none."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console

    with Console(stderr=True).status("measuring prices") as line:
        yield lambda part, share: line.update(f"measuring prices: {100.0 * share:.0f} %, {part}")
