"""The colours of all pictures: for algorithms, states of slave nodes, and fields.

An algorithm has one colour, the same in every report, plot and recording: it follows from the name alone. The first
six colours are from Okabe and Ito ("Color universal design", 2008) and stand out on white and on black; the others
were chosen as far from these and from each other as possible, also for readers without red or green cones. Markers
distinguish lines in grey, and names whose colours happen to be equal.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from hashlib import blake2b
from typing import Final


@dataclass(frozen=True)
class Style:
    """Drawing style of an algorithm: `colour` as #rrggbb and a matplotlib `marker`."""

    colour: str
    marker: str

    @property
    def rgb(self) -> tuple[int, int, int]:
        """Return the colour as red, green and blue, 0 to 255 each."""
        return rgb(self.colour)


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of "#rrggbb"."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


STYLES: Final = (
    Style("#0072B2", "o"),  # blue
    Style("#D55E00", "s"),  # vermillion
    Style("#009E73", "D"),  # bluish green
    Style("#CC79A7", "^"),  # reddish purple
    Style("#E69F00", "v"),  # orange
    Style("#56B4E9", "P"),  # sky blue
)
"""Styles of a few things next to each other."""

PALETTE: Final = (
    *(style.colour for style in STYLES), "#873741", "#6C407F", "#5CB572", "#B2548D", "#804300", "#D98941", "#BF5546",
    "#006768", "#7F99EF", "#708500",
)  # fmt: skip
"""Colours of names."""

MARKERS: Final = ("o", "s", "D", "^", "v", "P", "X", "*")

REFERENCE: Final = "#8A8F98"
"""Grey of reference solutions."""

STATES: Final = ("#9AA0A6", "#56B4E9", "#D55E00")
"""Colours of slave nodes that are open, stick, slip (by `contactlab.api.frame.STATES`)."""

CLOSED: Final = "#F4F1EA"
"""Colour of a closed slave node without friction: it neither sticks nor slips."""

FIELD: Final = (
    "#00224e", "#002e6a", "#1a386f", "#32436d", "#434e6c", "#535a6d", "#61656f", "#6f7073", "#7d7c78",
    "#8b8778", "#9a9376", "#aaa073", "#bbad6d", "#ccba64", "#ddc858", "#efd748", "#fee838",
)  # fmt: skip
"""Colours from the lowest value of a field to the highest: "cividis" by Nunez, Anderton and Renslow (2018),
which reads the same for all readers and in grey."""

_SALT: Final = (1352049).to_bytes(
    4, "big"
)  # any number gives fixed colours; with this one usual names have different ones


def style_of(name: str) -> Style:
    """Return the style of an algorithm."""
    number = blake2b(name.encode(), digest_size=2, salt=_SALT).digest()[0] % len(PALETTE)
    return Style(PALETTE[number], MARKERS[number % len(MARKERS)])


def styles(names: Iterable[str]) -> dict[str, Style]:
    """Return a style for each of the names that appear together, in their order. A name always has its own colour.

    Alphabetically later names get the next free marker, or else the next marker free with their colour.
    """
    names = list(dict.fromkeys(names))
    chosen: dict[str, Style] = {}
    for name in sorted(names):
        own = style_of(name)
        first = MARKERS.index(own.marker)
        every = [Style(own.colour, marker) for marker in (*MARKERS[first:], *MARKERS[:first])]
        markers, taken = {style.marker for style in chosen.values()}, set(chosen.values())
        free = [style for style in every if style.marker not in markers] or [s for s in every if s not in taken]
        chosen[name] = free[0] if free else own
    return {name: chosen[name] for name in names}
