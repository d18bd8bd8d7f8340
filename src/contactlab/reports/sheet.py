"""The one type of table that is shown: on a terminal, on a page, in Markdown, in LaTeX and as plain text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType
    from rich.table import Table as RichTable

STYLES = {
    "finished": "green", "cheapest": "bold green", "tied": "green", "not-converged": "yellow", "grey": "dim",
    "not-run": "dim", "title": "bold", "unit": "dim", "missed": "yellow", "silent": "bold red",
    **dict.fromkeys(("failed", "diverged", "refused", "interrupted", "timed-out"), "red"),
}  # fmt: skip
"""Styles of a terminal for kinds of cells; on a page kinds are classes."""

WORDS: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": True}
"""How lines are broken: numbers such as 6.1e-13 and keys stay whole."""

_SPECIAL = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "∞": r"$\infty$", "²": r"$^2$", "µ": r"$\mu$",
}  # fmt: skip


@dataclass(frozen=True)
class Column:
    """Heading of a column, and what may become of the column.

    short    heading on a terminal, if not the title
    meaning  shown where a reader points at the heading
    number   aligned to the right
    whole    cells are not folded over lines
    keep     stays on a narrow terminal, even if all rows have the same text or none
    leaves   turn in which it leaves a narrow terminal: 1 before 2; 0 stays, unless all rows have the same text
    leads    stands before each part of a table that is too wide for a terminal
    extra    shown on a page on demand
    """

    title: str
    unit: str = ""
    short: str = ""
    meaning: str = ""
    number: bool = False
    whole: bool = False
    keep: bool = False
    leaves: int = 0
    leads: bool = False
    extra: bool = False

    @property
    def line(self) -> str:
        """Heading in one line, with its unit."""
        return f"{' '.join((self.short or self.title).split())} {self.unit}".rstrip()


@dataclass(frozen=True)
class Cell:
    """A text and how it is shown.

    value     what rows are sorted by, if not the text
    kind      class on a page, style on a terminal (`STYLES`)
    mark      follows the text on a terminal
    hint, link, swatches  on a page: what is shown where a reader points at it, where it leads to, colours before it
    """

    text: str
    value: float | None = None
    kind: str = ""
    mark: str = ""
    hint: str = ""
    link: str = ""
    swatches: Sequence[str] = ()

    @property
    def order(self) -> str | None:
        """Number to sort by as a page holds it, empty for NaN."""
        return None if self.value is None else "" if math.isnan(self.value) else repr(self.value)


class Line:
    """A row: cells or what they show, remarks beneath it on a page (code, text), and whether it ends a section."""

    def __init__(
        self, cells: Iterable[object], kind: str = "", below: Sequence[tuple[str, str]] = (), ends: bool = False
    ) -> None:
        self.cells = [cell if isinstance(cell, Cell) else Cell(str(cell)) for cell in cells]
        self.kind, self.below, self.ends = kind, below, ends


def numbers(*titles: str) -> list[Column]:
    """Columns of numbers."""
    return [Column(title, number=True) for title in titles]


class Sheet:
    """Columns and rows with a title; `more` says where to find columns that had to leave a narrow terminal."""

    def __init__(
        self, columns: Iterable[Column | str], rows: Iterable[Line | Iterable[object]], title: str = "",
        more: str = "",
    ) -> None:  # fmt: skip
        self.columns = [column if isinstance(column, Column) else Column(column) for column in columns]
        self.rows = [row if isinstance(row, Line) else Line(row) for row in rows]
        self.title, self.more = title, more

    def texts(self, k: int) -> list[str]:
        """Texts of the column with number `k`."""
        return [row.cells[k].text for row in self.rows]

    # --- on a terminal ---

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Draw what fits, in parts if columns lead, and name what had to leave."""
        from rich.text import Text

        shown, left = self.fitting(options.max_width)
        for part in self.parts(shown, options.max_width):
            yield self.drawn(part, options.max_width)
        same = [k for k in left if self._same(k)]
        said = (f"{self.columns[k].title} {self.texts(k)[0]} {self.columns[k].unit}".strip() for k in same)
        if same:
            yield Text(f"in every row: {', '.join(said)}")
        titles = [self.columns[k].title for k in sorted(left) if k not in same]
        if titles:
            yield Text(f"not shown for lack of width: {', '.join(titles)} ({self.more})", style="dim")

    def fitting(self, width: int) -> tuple[list[int], list[int]]:
        """Numbers of the columns that fit into `width`, and of those that leave, in this order.

        Empty columns are in neither. Columns with the same text in every row leave first, numbers from the last on.
        """
        shown = [k for k, column in enumerate(self.columns) if column.keep or any(self.texts(k)) or not self.rows]
        free = [k for k in shown if not self.columns[k].keep]
        turns = ([k for k in reversed(free) if self.columns[k].leaves == turn] for turn in (1, 2))
        left: list[int] = []
        for k in dict.fromkeys([*filter(self._same, free), *(k for turn in turns for k in turn)]):
            if self.width(shown) <= width:
                break
            shown.remove(k)
            left.append(k)
        return shown, left

    def _same(self, k: int) -> bool:
        return len(self.rows) > 1 and len(set(self.texts(k))) == 1

    def width(self, shown: Sequence[int]) -> int:
        """Width of a terminal that these columns need unfolded."""
        return _framed([self._widest(k) for k in shown])

    def parts(self, shown: Sequence[int], width: int) -> list[list[int]]:
        """Columns that are drawn together: all, or, behind those that lead, as many as fit without cutting words."""
        lead = [k for k in shown if self.columns[k].leads]
        parts = [list(lead)]
        for k in (k for k in shown if k not in lead or not lead):
            if lead and len(parts[-1]) > len(lead) and _framed(map(self._least, [*parts[-1], k])) > width:
                parts.append(list(lead))
            parts[-1].append(k)
        return [sorted(part) for part in parts]

    def _lines(self, k: int) -> Iterator[tuple[str, str]]:
        """Each line of the column, heading included, with its mark."""
        heading = (self.columns[k].short or self.columns[k].title).split("\n")
        yield from ((line, "") for line in (*heading, self.columns[k].unit))
        for cell in (row.cells[k] for row in self.rows):
            yield from ((line, cell.mark) for line in cell.text.split("\n"))

    def _widest(self, k: int) -> int:
        return max(len(line) + len(mark) for line, mark in self._lines(k))

    def _least(self, k: int) -> int:
        """Width below which words of the column would be cut."""
        if self.columns[k].whole:
            return self._widest(k)
        return max(len(word) + len(mark) for line, mark in self._lines(k) for word in wrap(line, 1, **WORDS) or [""])

    def widths(self, shown: Sequence[int], width: int) -> list[int | None]:
        """Width of each column: the widest are folded first, and no word is cut if that is possible."""
        found, least = [self._widest(k) for k in shown], [self._least(k) for k in shown]
        if _framed(found) <= width or _framed(least) > width:
            return [None] * len(shown)
        while _framed(found) > width:
            found[max((k for k in range(len(shown)) if found[k] > least[k]), key=found.__getitem__)] -= 1
        return list(found)

    def drawn(self, shown: Sequence[int], width: int) -> RichTable:
        """Table of these columns for a terminal."""
        from rich import box
        from rich.table import Table
        from rich.text import Text

        made = Table(
            box=box.SIMPLE_HEAD, collapse_padding=True, pad_edge=False, title=Text(self.title) if self.title else None,
            title_justify="left", title_style="bold", show_header=any(self.columns[k].title for k in shown),
        )  # fmt: skip
        widths = self.widths(shown, width)
        for column, wide in zip((self.columns[k] for k in shown), widths, strict=True):
            heading = Text(_folded(column.short or column.title, wide))
            if column.unit:
                heading.append(f"\n{column.unit}", style="dim")
            made.add_column(
                heading, overflow="fold", no_wrap=column.whole, justify="right" if column.number else "left",
                width=wide,
            )  # fmt: skip
        for row in self.rows:
            cells = zip((row.cells[k] for k in shown), widths, strict=True)
            texts = (
                Text(_folded(cell.text, wide and wide - len(cell.mark)), STYLES.get(cell.kind, "")).append(
                    cell.mark, "bold yellow"
                )
                for cell, wide in cells
            )
            made.add_row(*texts, end_section=row.ends)
        return made

    # --- elsewhere ---

    def html(self, kind: str = "", name: str = "", caption: str = "", sortable: bool = False) -> str:
        """Table of a page with classes `kind` and identifier `name`; `sortable` by a click on a heading."""
        from contactlab.reports.html import filled

        kinds = f"{kind} sortable".strip() if sortable else kind
        return filled("table.html", sheet=self, kind=kinds, identifier=name, caption=caption, sortable=sortable)

    def markdown(self) -> str:
        """Table in Markdown, without a line break at its end."""
        head = [" ".join(f"{column.title} {column.unit}".split()) for column in self.columns]
        rows = [[" ".join(cell.text.replace("|", "\\|").split()) for cell in row.cells] for row in self.rows]
        lines = [f"| {' | '.join(cells)} |" for cells in (head, *rows)]
        return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])

    def tex(self) -> str:
        """`tabular` of LaTeX with the rules of booktabs; units in a line of their own."""

        def line(cells: Iterable[str]) -> str:
            return " & ".join(cells) + r" \\"

        rows = [
            line(
                tex_number(cell.text) if column.number else escaped(cell.text)
                for column, cell in zip(self.columns, row.cells, strict=True)
            )
            for row in self.rows
        ]
        return "\n".join(
            [
                rf"\begin{{tabular}}{{{''.join('r' if column.number else 'l' for column in self.columns)}}}",
                r"\toprule",
                line(escaped(column.title) for column in self.columns),
                line(f"[{escaped(column.unit)}]" if column.unit else "" for column in self.columns),
                r"\midrule",
                *rows,
                r"\bottomrule",
                r"\end{tabular}",
            ]
        )

    def text(self, most: int) -> str:
        """Title and up to `most` lines of plain text, with a word on rows beyond."""
        rows = [[cell.text for cell in row.cells] for row in self.rows]
        shown = rows if len(rows) <= most - 2 else rows[: most - 3]
        heads = [column.line for column in self.columns]
        widths = [max(map(len, column)) for column in zip(heads, *shown, strict=True)]
        lines = [
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
            for row in (heads, *shown)
        ]
        more = [] if len(shown) == len(rows) else [f"... and {len(rows) - len(shown)} more"]
        return "\n".join([self.title, *lines, *more])


def _framed(widths: Iterable[int]) -> int:
    """Width of a table with columns of these widths: two characters between columns, and one on either side."""
    return sum(width + 2 for width in widths)


def _folded(text: str, width: int | None) -> str:
    """The text in lines of at most so many characters, broken between words and behind hyphens between letters."""
    if width is None:
        return text
    return "\n".join("\n".join(wrap(line, max(1, width), **WORDS)) for line in text.split("\n"))


def escaped(text: str) -> str:
    """Write out characters that LaTeX takes for commands."""
    return "".join(_SPECIAL.get(character, character) for character in text)


def tex_number(text: str) -> str:
    """A number as mathematics: 1.2e-5 becomes a power of ten, a missing one a dash."""
    if text == "\N{EN DASH}":
        return "--"
    mantissa, power, exponent = text.partition("e")
    return rf"${mantissa}\cdot 10^{{{int(exponent)}}}$" if power else f"${text}$".replace("∞", r"\infty")


def facts(title: str, lines: Iterable[tuple[str, str]]) -> Sheet:
    """Names with their values, without a heading."""
    return Sheet(
        [Column("", whole=True), Column("")], ([Cell(name, kind="title"), text] for name, text in lines), title
    )
