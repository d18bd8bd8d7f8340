"""Command line whose errors have the form of all others: what was got, what is allowed, and what to try."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import Any, NoReturn

from contactlab.errors import RequestError, did_you_mean, nearest

GOT = re.compile(r"argument (?P<name>[^:]+): got (?P<got>.*), allowed: (?P<allowed>.*)", re.DOTALL)
CHOICE = re.compile(r"argument (?P<name>[^:]+): invalid choice: (?P<got>.*) \(choose from (?P<allowed>.*)\)", re.DOTALL)
EXPECTED = re.compile(r"argument (?P<name>[^:]+): expected .*argument", re.DOTALL)
REQUIRED = re.compile(r"the following arguments are required: (?P<name>.*)", re.DOTALL)


def _is_text(word: str) -> bool:
    """Return whether a word is UTF-8; other bytes of the command line arrive as surrogates."""
    try:
        return b"\0" not in word.encode()
    except UnicodeEncodeError:
        return False


def usage_of(parser: argparse.ArgumentParser) -> str:
    """Return the usage of a command on one line."""
    return " ".join(parser.format_usage().removeprefix("usage: ").replace("[-h] ", "").split())


def name_of(parser: argparse.ArgumentParser) -> str:
    """The command of a parser; empty for the whole program, which errors name themselves."""
    return parser.prog.partition(" ")[2]


def _below(where: str, name: str) -> str:
    return f"{where}, {name}" if where else name


class CommandLine(argparse.ArgumentParser):
    """A parser that raises RequestError instead of printing its usage and exiting."""

    def error(self, message: str) -> NoReturn:
        """Raise a RequestError for a message of argparse."""
        usage, where, more = usage_of(self), name_of(self), f"{self.prog} --help"
        if found := GOT.fullmatch(message) or CHOICE.fullmatch(message):
            allowed = found["allowed"].replace("'", "")
            got = found["got"].strip("'")
            hint = did_you_mean(got, allowed.split(", ")) if "invalid choice" in message else ""
            raise RequestError(
                "this value is not allowed", where=_below(where, found["name"]), got=got, allowed=allowed, hint=hint
            )
        if found := EXPECTED.fullmatch(message):
            raise RequestError("a value is missing", where=_below(where, found["name"]), allowed=usage, hint=more)
        if found := REQUIRED.fullmatch(message):
            raise RequestError(f"{found['name']} is missing", where=where, allowed=usage, hint=more)
        raise RequestError(message, where=where, allowed=usage, hint=more)

    def read(self, words: Sequence[str]) -> argparse.Namespace:
        """Parse the words, and keep them as `words`. Raises RequestError, with what the command takes in its place."""
        for word in words:
            if not _is_text(word):
                raise RequestError(
                    "a word has characters that no file can store", got=ascii(word), allowed="UTF-8 text without NUL",
                    hint="" if "\0" in word else "if it looks right, set PYTHONUTF8=1",
                )  # fmt: skip
        options, left = self.parse_known_args(words)
        if left:
            self._refuse(left, words)
        options.words = list(words)
        return options

    def _refuse(self, left: Sequence[str], words: Sequence[str]) -> NoReturn:
        command = self._command(words)
        word = left[0].partition("=")[0]
        known = [name for action in command._actions for name in action.option_strings if name.startswith("--")]
        if not word.startswith("-"):
            raise RequestError("unexpected word", where=name_of(command), got=left[0], allowed=usage_of(command))
        keys = "keys of a scene are set by --set KEY=VALUE, such as --set level=2" if "--set" in known else ""
        # without the dashes, which every option shares
        near = nearest(word.lstrip("-"), [name.lstrip("-") for name in known if name != "--help"])
        hint = f'did you mean "--{near}"?' if near else keys
        raise RequestError("unknown option", where=name_of(command), got=word, allowed=", ".join(known), hint=hint)

    def _command(self, words: Sequence[str]) -> argparse.ArgumentParser:
        """The parser of the command among the words; this parser if there is none."""
        named: Any = next((a.choices for a in self._actions if isinstance(a, argparse._SubParsersAction)), {})
        return next((named[word] for word in words if word in named), self)
