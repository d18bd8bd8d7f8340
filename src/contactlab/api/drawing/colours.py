"""The colours of all pictures: of algorithms, of the states of a slave node, of fields.

An algorithm has one colour and one marker, the same in every report, plot and recording.
The colours are those of Okabe and Ito ("Color universal design", 2008) that stand out on white and
on black; readers with any colour vision can distinguish them, and markers do so in grey. No
algorithm is named here: a name always leads to the same colour.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Style:
    """How an algorithm is drawn: `colour` as #rrggbb and a matplotlib `marker`."""

    colour: str
    marker: str

    @property
    def rgb(self) -> tuple[int, int, int]:
        """The colour as red, green and blue, 0 to 255 each."""
        return rgb(self.colour)


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green and blue, 0 to 255, of "#rrggbb"."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


STYLES: Final = (
    Style("#0072B2", "o"),  # blue
    Style("#D55E00", "s"),  # vermillion
    Style("#009E73", "D"),  # bluish green
    Style("#CC79A7", "^"),  # reddish purple
    Style("#E69F00", "v"),  # orange
    Style("#56B4E9", "P"),  # sky blue
)
REFERENCE: Final = "#8A8F98"
"""Grey of reference solutions."""

STATES: Final = ("#9AA0A6", "#56B4E9", "#D55E00")
"""Of a slave node that is open, sticks, slips (by `contactlab.api.frame.STATES`)."""

CLOSED: Final = "#F4F1EA"
"""Of a closed slave node without friction: it neither sticks nor slips."""

FIELD: Final = (
    "#00224e", "#002e6a", "#1a386f", "#32436d", "#434e6c", "#535a6d", "#61656f", "#6f7073", "#7d7c78",
    "#8b8778", "#9a9376", "#aaa073", "#bbad6d", "#ccba64", "#ddc858", "#efd748", "#fee838",
)  # fmt: skip
"""From the lowest value of a field to the highest, evenly spaced: "cividis" by Nunez, Anderton and Renslow (2018),
which reads the same for all readers and in grey."""

_SALT: Final = 1818  # any number gives fixed colours; this one keeps common names apart


def styles(names: Iterable[str]) -> dict[str, Style]:
    """A style for each of the names that appear together; equal styles only beyond six names.

    A name keeps its own style unless an alphabetically earlier one in the same picture holds it.
    The result is in the order of the names as given.
    """
    names = list(dict.fromkeys(names))
    taken: dict[int, str] = {}
    chosen: dict[str, Style] = {}
    for name in sorted(names):
        slot = _free_slot(_own_slot(name), taken)
        taken[slot] = name
        chosen[name] = STYLES[slot]
    return {name: chosen[name] for name in names}


def _own_slot(name: str) -> int:
    return zlib.crc32(f"{_SALT}:{name}".encode()) % len(STYLES)


def _free_slot(slot: int, taken: dict[int, str]) -> int:
    for step in range(len(STYLES)):
        candidate = (slot + step) % len(STYLES)
        if candidate not in taken:
            return candidate
    return slot
