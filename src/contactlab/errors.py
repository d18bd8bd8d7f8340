"""Every exception of the project: each names where, what was got, what is allowed and what to try."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final


class _Nothing:
    """Marks "no value given", if None would be a value."""

    def __repr__(self) -> str:
        return "nothing"


NOTHING: Final = _Nothing()


class ContactlabWarning(RuntimeWarning):
    """Something a run or comparison did without: `warnings` names no line of code where the program prints it."""


@dataclass(frozen=True)
class Location:
    """A key of a scene or study: the file, the dotted key, and the line if it is known.

    file       name of the text for the reader: a path, or the name of a bundled scene
    key        dotted path, "contacts.0.algorithm"
    lines      line numbers of the keys that the file writes out
    overrides  keys that were set from outside the file and therefore have no line in it
    folder     where relative paths in the text start from; empty: the working folder
    """

    file: str = ""
    key: str = ""
    lines: Mapping[str, int] = field(default_factory=dict, repr=False, compare=False)
    overrides: frozenset[str] = field(default=frozenset(), repr=False, compare=False)
    folder: str = field(default="", repr=False, compare=False)

    def at(self, key: str) -> Location:
        """The location of a dotted key in the same text."""
        return Location(self.file, key, self.lines, self.overrides, self.folder)

    def child(self, name: str | int) -> Location:
        """The location of `name` inside this table."""
        return self.at(f"{self.key}.{name}" if self.key else str(name))

    @property
    def line(self) -> int | None:
        """Line of the key, or of the innermost table around it that the file writes out."""
        for key in _ancestors(self.key):
            if key in self.overrides:
                return None
            if key in self.lines:
                return self.lines[key]
        return None

    def __str__(self) -> str:
        if any(key in self.overrides for key in _ancestors(self.key)):
            return f"{self.file}, key {self.key} (set from outside the file)"
        line = f", line {self.line}" if self.line is not None else ""
        key = f"key {self.key}" if self.key else ""
        return ", ".join(text for text in (f"{self.file}{line}".strip(", "), key) if text)


def _ancestors(key: str) -> Iterable[str]:
    while key:
        yield key
        key = key.rpartition(".")[0]


Where = str | Location


def below(where: Where, name: str | int) -> Where:
    """The place of `name` inside the table at `where`."""
    if isinstance(where, Location):
        return where.child(name)
    return f"{where}.{name}" if where else str(name)


def one_line(error: BaseException, name: bool = True) -> str:
    """An exception as one line: its type, its text, and the place it came from."""
    text = "; ".join(" ".join(visible(line).split()) for line in str(error).splitlines() if line.strip())
    kind = type(error).__name__
    return f"{kind}: {text}" if name and text else text or kind


def visible(text: str, kept: str = "\n\t") -> str:
    """A string whose control characters, except those `kept`, are made visible and cannot control a terminal."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in kept else _seen(ord(c)) for c in text)


def _seen(code: int) -> str:
    if code < 32 or code == 127:
        return chr(0x2400 + code if code < 32 else 0x2421)
    return chr(code) if chr(code).isspace() else "\N{REPLACEMENT CHARACTER}"


DEEPEST = 6  # tables in tables that are shown
LONGEST = 60  # entries of a list: more than a line has room for


def show(value: object, most: int = 120) -> str:
    """A value as a scene file would write it, shortened to one line of at most so many characters."""
    text = visible(_written(value, DEEPEST), "")
    return text if len(text) <= most else text[: most - 3] + "..."


def _written(value: object, depth: int) -> str:
    if depth == 0 and isinstance(value, Mapping | list | tuple):
        return "..."  # it may contain itself
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_written(item, depth - 1)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_written(item, depth - 1) for item in value[:LONGEST]) + "]"
    if isinstance(value, int) and value.bit_length() > 200:
        return f"an integer of {value.bit_length() * 0.30103:.0f} digits"  # Python writes none of more than 4300
    return str(value)


TOLD = 9  # further errors of a file that are shown
MISSPELT = 0.88
"""Ratio of difflib above which a name is another with a letter of eight missing, doubled or exchanged."""


def nearest(name: str, choices: Iterable[str]) -> str | None:
    """The choice most like `name`, None if nothing is close; misspelt ones first, then whole words it begins with."""
    from difflib import get_close_matches

    wanted, by_fold = name.casefold(), {choice.casefold(): choice for choice in choices}
    begins = sorted((choice for choice in by_fold if wanted.startswith(f"{choice}-")), key=len)
    close = get_close_matches(wanted, by_fold, 1, MISSPELT) or begins[-1:] or get_close_matches(wanted, by_fold, 1, 0.5)
    return by_fold[close[0]] if close else None


def did_you_mean(name: str, choices: Iterable[str]) -> str:
    """Suggest the nearest choice, as in `write "nearest"`; nothing when none is close."""
    close = nearest(name, choices)
    return f'did you mean "{close}"?' if close else ""


class ContactlabError(Exception):
    """Base of all errors of the project; `exit_status` is what the command line returns."""

    exit_status = 1


class RequestError(ContactlabError):
    """The request is wrong; nothing was run.

    problem  one sentence
    where    file and key, or the part
    got      the offending value as it was written
    allowed  what would have been accepted
    hint     what to try
    others   what else is wrong in the same file
    """

    exit_status = 2

    def __init__(
        self,
        problem: str,
        *,
        where: Where = "",
        got: Any = NOTHING,
        allowed: str = "",
        hint: str = "",
        others: tuple[RequestError, ...] = (),
    ) -> None:
        self.problem = problem
        self.where = where
        self.got = got
        self.allowed = allowed
        self.hint = hint
        self.others = others
        super().__init__(problem)

    def __str__(self) -> str:
        where = str(self.where)
        rows = [visible(f"{where}: {self.problem}" if where else self.problem)]
        details = {
            "got": "" if self.got is NOTHING else show(self.got),
            "allowed": self.allowed,
            "try": self.hint,
        }
        rows += [f"  {label:<8} {visible(text)}" for label, text in details.items() if text]
        rows += [str(other) for other in self.others[:TOLD]]
        if len(self.others) > TOLD:
            rows.append(f"and {len(self.others) - TOLD} more errors")
        return "\n".join(rows)

    def __reduce__(self) -> tuple[Any, ...]:
        # the default would call the class with the message alone and lose the rest between processes
        return _rebuild, (
            type(self), self.problem, self.where, self.got, self.allowed, self.hint, self.others,
        )  # fmt: skip


def _rebuild(
    kind: type[RequestError], problem: str, where: Where, got: Any, allowed: str, hint: str,
    others: tuple[RequestError, ...],
) -> RequestError:  # fmt: skip
    got = NOTHING if isinstance(got, _Nothing) else got
    return kind(problem, where=where, got=got, allowed=allowed, hint=hint, others=others)


class Gathered:
    """Errors of several keys, to be told together: `with gathered: ...` keeps an error and goes on behind it."""

    def __init__(self) -> None:
        self.found: list[RequestError] = []

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> bool:
        if not isinstance(error, RequestError):
            return False
        self.found += [error, *error.others]
        error.others = ()
        return True

    def tell(self) -> None:
        """Raise the first error, which names the others; nothing without one."""
        if self.found:
            self.found[0].others = tuple(self.found[1:])
            raise self.found[0].with_traceback(None)  # or it shows the way through every table


class SceneError(RequestError):
    """Something in a scene is wrong: a key, a value, or what they ask for together."""


class PartError(RequestError):
    """A part is unknown, cannot be imported, or does not keep the contract."""


class WrongAnswer(ValueError):
    """Value of a part that breaks the contract: the part and its method, what was got, what is needed."""


class SimulationFailure(ContactlabError):
    """A run that was rightly asked for did not come to its end.

    status  diverged, not-converged or failed
    reason  what happened, where, and what to try
    """

    def __init__(self, status: str, reason: str) -> None:
        self.status = status
        self.reason = reason
        super().__init__(status, reason)

    def __str__(self) -> str:
        return f"{self.status}: {self.reason}"


class NotFiniteError(SimulationFailure):
    """The state of a run has something in it that is no number; whose it was is not known yet."""
