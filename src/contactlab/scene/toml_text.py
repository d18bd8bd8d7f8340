"""TOML as people write it: files with line numbers, values on a command line, and tidy output."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from contactlab.errors import Location, SceneError
from contactlab.outside_files import read_outside

LARGEST = 16 << 20  # bytes of a scene or study

_AT_LINE = re.compile(r"^(?P<what>.*?) \(at (?:line (?P<line>\d+), column (?P<column>\d+)|end of document)\)$")
_HEADER = re.compile(r"\s*(?P<open>\[\[?)\s*(?P<key>[^\[\]]+?)\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r"\s*(?P<key>[A-Za-z0-9_\"'. -]+?)\s*=")
_ENDLESS = re.compile(r"[0-9_]{4300}")
_DEEP = re.compile(r"""(?:[ \t]*+[\w"'-]*+[ \t]*+\.){2000}""")  # the reader of TOML takes gigabytes for a longer key
_TUPLE, _NAME = re.compile(r"\('.*?',?\)(?= |$)"), re.compile(r"'([^']*)'")
_DELIMITERS = ('"""', "'''")


def read_toml(path: Path, shown: str) -> tuple[dict[str, Any], dict[str, int]]:
    """Data of a TOML file and the line of each key. Raises SceneError; `shown` names the file in it."""
    content = read_outside(path, shown, "a TOML file", LARGEST, SceneError)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        got = repr(content[error.start : error.start + 4])
        raise SceneError(
            f"not a text file: line {line} is not UTF-8", where=shown, got=got, allowed="a TOML file in UTF-8"
        ) from error
    return parse_toml(text, shown), key_lines(text)


def parse_toml(text: str, shown: str) -> dict[str, Any]:
    """The data of a TOML text. Raises SceneError with the line."""
    if (deep := _DEEP.search(text)) is not None:
        where = f"{shown}, line {text.count(chr(10), 0, deep.end()) + 1}"
        got = f"{text[deep.start() : deep.start() + 40].strip()}..."
        raise SceneError("the key has too many parts", where=where, got=got, allowed="less than 2000, joined by dots")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _broken_toml(text, str(error), shown) from error
    except RecursionError as error:
        got = f"{len(text)} characters"
        raise SceneError("this is nested too deeply", where=shown, got=got, allowed="a scene in TOML") from error
    except ValueError as error:  # Python reads no integer of more than 4300 digits
        line = next((n for n, row in enumerate(text.splitlines(), 1) if _ENDLESS.search(row)), 0)
        where = f"{shown}, line {line}" if line else shown
        raise SceneError(
            "the integer has too many digits", where=where, got=str(error), allowed="numbers below 1e19"
        ) from error


_HINTS = {
    "Invalid value": "strings need quotes; booleans are lower case: true, false",
    "Cannot overwrite": "the key is in the file twice: remove one",
    "Duplicate inline table key": "the key is in the table twice: remove one",
    "Cannot mutate": "what is written in {} or [] is complete there: write the key or entry inside",
    "Unclosed array": "close it with ]",
}


def _broken_toml(text: str, message: str, shown: str) -> SceneError:
    match = _AT_LINE.match(message)
    if match is None:
        return SceneError(f"invalid TOML: {message}", where=shown, got=text[:80], allowed="a TOML file")
    lines = text.splitlines() or [""]
    number = min(int(match["line"] or len(lines)), len(lines))
    got = lines[number - 1].strip()
    shown_line = got if got.isprintable() else repr(got)
    what = _TUPLE.sub(lambda names: ".".join(_NAME.findall(names[0])), match["what"])
    return SceneError(
        f"invalid TOML: {what[0].lower()}{what[1:]}",
        where=f"{shown}, line {number}",
        got=shown_line,
        allowed="key = value, [table] or [[list of tables]]",
        hint=_table_hint(lines[:number])
        or next((hint for start, hint in _HINTS.items() if match["what"].startswith(start)), ""),
    )


def _table_hint(lines: Sequence[str]) -> str:
    """Return a hint for the table header in the last of these lines; empty if the line is not a header."""
    headers = [header for line in lines if (header := _HEADER.match(line))]
    if not headers or not _HEADER.match(lines[-1]):
        return ""
    key, brackets = _dotted(headers[-1]["key"]), headers[-1]["open"]
    before = next((header["open"] for header in headers[:-1] if _dotted(header["key"]) == key), "")
    if not before:
        return f"the table or list of {key} stands above after =, and is complete there: write this inside its brackets"
    if before == brackets:
        return "the table is in the file twice: join them"
    return f"write [[{key}]] above each entry of a list, [{key}] above a single table"


def location(shown: str, lines: Mapping[str, int]) -> Location:
    """The top of a file, from which the place of every key follows."""
    return Location(file=shown, lines=lines)


def key_lines(text: str) -> dict[str, int]:
    """Line number of each dotted key that begins a line; entries of lists of tables by their number."""
    lines: dict[str, int] = {}
    counts: dict[str, int] = {}
    table = ""
    inside = ""
    for number, line in enumerate(text.splitlines(), start=1):
        inside, skip = _multiline(line, inside), bool(inside)
        if skip:
            continue
        if header := _HEADER.match(line):
            table = _numbered(_dotted(header["key"]), counts, new=header["open"] == "[[")
            lines.setdefault(table, number)
        elif assignment := _KEY.match(line):
            name = _dotted(assignment["key"])
            lines.setdefault(f"{table}.{name}" if table else name, number)
    return lines


def _multiline(line: str, inside: str) -> str:
    """The delimiter of the multi-line string that is open after this line, "" for none."""
    for delimiter in (inside,) if inside else _DELIMITERS:
        if line.count(delimiter) % 2:
            return "" if inside else delimiter
    return inside


def _dotted(key: str) -> str:
    return ".".join(part.strip().strip("\"'") for part in key.split("."))


def _numbered(key: str, counts: dict[str, int], new: bool) -> str:
    """A table's path with the entry numbers of the lists of tables on the way."""
    if new:
        counts[key] = counts.get(key, -1) + 1
    path = ""
    plain = ""
    for name in key.split("."):
        plain = f"{plain}.{name}" if plain else name
        path = f"{path}.{name}" if path else name
        if plain in counts:
            path += f".{counts[plain]}"
    return path


_TOKEN = re.compile(
    r"""(?P<quoted>"(?:\\.|[^"\\])*"|'[^']*')"""
    r"""|(?P<bare>[A-Za-z_][\w./+-]*)(?P<assigned>\s*=)?"""
    r"""|(?P<number>[\d+.-][\w.:+-]*)"""
)
_CONSTANTS = {"true", "false", "inf", "nan"}


def parse_value(text: str, where: str) -> Any:
    """A value from a command line: TOML in which bare words are texts.

    Raises SceneError for a list or table that is no TOML even so.
    """
    for candidate in (text, _TOKEN.sub(_quote, text)):
        try:
            found = tomllib.loads(f"value = {candidate}")
        except (tomllib.TOMLDecodeError, RecursionError):
            continue
        except ValueError as error:  # an integer of more than 4300 digits
            raise SceneError(
                "the integer has too many digits", where=where, got=text, allowed="numbers below 1e19"
            ) from error
        if set(found) == {"value"}:
            return found["value"]
    if text.lstrip()[:1] in ("[", "{", '"', "'"):
        allowed = 'a TOML value, such as 2, true, mortar-p1, [4, 4] or {use="coulomb", mu=0.2}'
        raise SceneError("the value cannot be read", where=where, got=text, allowed=allowed)
    return text


def _quote(match: re.Match[str]) -> str:
    bare = match["bare"]
    if bare is None or match["assigned"] or bare in _CONSTANTS:
        return match[0]
    return f'"{bare}"'


def write_toml(data: Mapping[str, Any]) -> str:
    """TOML text that reads back as exactly `data`, laid out like a scene written by hand.

    Tables of the first two levels get a header, deeper ones stay on the line of their key.
    """
    return "\n".join(_table(data, ())).lstrip("\n") + "\n"


def _table(data: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    rows = [f"{_name(name)} = {_inline(value)}" for name, value in data.items() if not _has_header(value, path)]
    for name, value in data.items():
        inner = (*path, name)
        dotted = ".".join(map(_name, inner))
        if not _has_header(value, path):
            continue
        if isinstance(value, list):
            for entry in value:
                rows += ["", f"[[{dotted}]]", *_table(entry, (*inner, "N"))]
        else:
            body = _table(value, inner)
            # a table that only holds tables needs no header of its own
            rows += body if body and not body[0] else ["", f"[{dotted}]", *body]
    return rows


def _has_header(value: object, path: tuple[str, ...]) -> bool:
    if isinstance(value, list):
        return not path and bool(value) and all(isinstance(entry, Mapping) for entry in value)
    return isinstance(value, Mapping) and len(path) < 2


def _name(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _inline(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_name(name)} = {_inline(item)}" for name, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return repr(value)


def _text(text: str) -> str:
    # JSON's escapes are TOML's, but for the delete character, which TOML wants escaped
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")
