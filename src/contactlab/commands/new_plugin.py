"""`contactlab new-plugin`: a package with a working part, its tests, and what a release needs."""

from __future__ import annotations

import argparse
import keyword
import re
import sys
import tomllib
from collections.abc import Mapping
from datetime import date
from importlib.util import find_spec
from pathlib import Path
from string import Template
from typing import Any

from contactlab import api
from contactlab.api.part import KINDS
from contactlab.errors import RequestError, did_you_mean
from contactlab.parts.registry import default_registry

TEMPLATES = Path(__file__).parents[1] / "data" / "new_plugin"
_SAID: Mapping[str, Mapping[str, Any]] = tomllib.loads((TEMPLATES / "kinds.toml").read_text())
WAYS: Mapping[str, Mapping[str, tuple[str, str, str]]] = {
    kind: {way: tuple(files) for way, files in said["ways"].items()} for kind, said in _SAID.items() if "ways" in said
}
"""Ways to write parts of a kind, the usual way first: the part, its tests, and its summary."""
_KEBAB = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")


def new_plugin(options: argparse.Namespace) -> int:
    """Write the package into a new folder of the working one, and say what to do with it."""
    folder = Path(options.name)
    files = plugin_files(options.kind, options.name, with_ci=options.with_ci, start=options.start)
    refuse_taken(options.kind, options.name)
    if folder.exists():
        raise RequestError("the folder exists already", got=str(folder), hint="another name, or another folder")
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    print(f"{folder}: a package with the {options.kind} {options.name}, in {len(files)} files")
    print(f"next: pip install -e '{folder}[test]' && pytest {folder}")
    print(f"then edit {folder}/src/{_module(options.name)}/{options.kind}.py until its tests pass")
    print(f"then: contactlab check {folder.name} --kind {options.kind}")
    if len(ways := [*WAYS.get(options.kind, ())]) > 1 and not options.start:
        print(f"it is written as {ways[0]}; other ways: --from {' or '.join(ways[1:])}")
    return 0


def plugin_files(kind: str, name: str, *, with_ci: bool = False, start: str = "") -> dict[str, str]:
    """Text of every file of the package, by its path. Raises RequestError for what is no kind, way or name.

    start  way in which the part is written, of `WAYS`; the usual one where it is empty
    """
    if kind not in KINDS:
        raise RequestError("no such kind of part", got=kind, allowed=", ".join(KINDS), hint=did_you_mean(kind, KINDS))
    refuse_name(name)
    ways = WAYS.get(kind, {"": ("part.py", "test.py", "")})
    way = start or next(iter(ways))
    if way not in ways:
        allowed = ", ".join(ways) if kind in WAYS else "nothing for this kind"
        raise RequestError("no such way to write a part", where="--from", got=way, allowed=allowed)
    part, test, summary = ways[way]
    words = _words(kind, name, summary)
    module = f"src/{_module(name)}"
    shared = {
        "pyproject.toml": "pyproject.toml",
        "README.md": "README.md",
        "LICENSE": "LICENSE",
        "CITATION.cff": "CITATION.cff",
        f"{module}/__init__.py": "init.py",
        f"{module}/plugin.py": "plugin.py",
    }
    if with_ci:
        shared[".github/workflows/checks.yml"] = "checks.yml"
    files = {path: _filled(f"common/{source}", words) for path, source in shared.items()}
    return files | {
        f"{module}/py.typed": "",
        f"{module}/{kind}.py": _filled(f"{kind}/{part}", words),
        f"tests/test_{_module(name)}.py": _filled(f"{kind}/{test}", words),
    }


def refuse_name(name: str) -> None:
    """Raise RequestError if `name` cannot be the name of a part, its module and its class."""
    hint = "lower-case words joined by -, such as my-contact"
    if not _KEBAB.fullmatch(name):
        raise RequestError("invalid name of a part", got=name, allowed=hint)
    module = _module(name)
    if keyword.iskeyword(module) or module in sys.stdlib_module_names:
        raise RequestError("a keyword or module of Python cannot be the name of a package", got=name, allowed=hint)
    if _class_name(name) in api.__all__:
        raise RequestError(f"its class would be called {_class_name(name)}, as one of contactlab.api", got=name)


def refuse_taken(kind: str, name: str) -> None:
    """Raise RequestError if a part or a package of this name is installed."""
    if name in default_registry().names(kind):
        offer = default_registry().offer(kind, name)
        raise RequestError(
            f"there is a {kind} of this name, from {offer.origin}", got=name, hint="two parts of a name are not used"
        )
    if find_spec(_module(name)) is not None:
        raise RequestError(f"a package {_module(name)} is installed; the new package would hide it", got=name)


def _words(kind: str, name: str, summary: str = "") -> dict[str, str]:
    """Return the values for the templates."""
    said = _SAID[kind]
    today = date.today()
    summary = summary or said["summary"]
    return {
        "kind": kind,
        "name": name,
        "module": _module(name),
        "class_name": _class_name(name),
        "summary": summary,
        "title": summary[0].upper() + summary[1:],
        "try_it": Template(said["try_it"]).substitute(name=name),
        "year": str(today.year),
        "date": today.isoformat(),
    }


def _filled(template: str, words: Mapping[str, str]) -> str:
    return Template((TEMPLATES / f"{template}.template").read_text()).substitute(words)


def _module(name: str) -> str:
    return name.replace("-", "_")


def _class_name(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("-"))
