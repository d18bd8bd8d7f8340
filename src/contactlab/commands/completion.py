"""`contactlab completion`: what a shell needs to complete commands, scenes, parts and keys."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import Any

from contactlab.errors import ContactlabError, RequestError


def completion(options: argparse.Namespace) -> int:
    """Print the lines that switch completion on in a shell."""
    sys.stdout.write(_argcomplete().shellcode(["contactlab"], shell=options.shell))
    return 0


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer the shell, which runs the program for completions; ends the process."""
    for action, completer in _completers(parser):
        action.completer = completer
    _argcomplete().autocomplete(parser)


def _argcomplete() -> Any:
    try:
        import argcomplete
    except ModuleNotFoundError as missing:
        raise RequestError(
            "completion needs the library argcomplete, which is not installed", where="completion",
            hint="pip install argcomplete",
        ) from missing  # fmt: skip
    return argcomplete


def _completers(parser: argparse.ArgumentParser) -> Any:
    """Arguments of all commands with what can stand there."""
    from argcomplete.completers import DirectoriesCompleter, FilesCompleter

    known = {
        "scene": scene_names, "source": scene_names, "name": names(""), "settings": settings, "vary": settings,
        "cases": names("case"), "contacts": names("contact"), "reference": reference_names, "kind": kinds,
        "files": FilesCompleter(("py",)), "out": DirectoriesCompleter(), "path": DirectoriesCompleter(),
        "target": targets,
    }  # fmt: skip
    commands = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    for name, command in commands.choices.items():
        for action in command._actions:
            if action.dest in known and (action.dest != "name" or name == "parts"):
                yield action, known[action.dest]


def scene_names(prefix: str, **_: Any) -> list[str]:
    """Names of the bundled scenes, and TOML files nearby."""
    from argcomplete.completers import FilesCompleter

    from contactlab.scene.scene import bundled_scenes

    return [*bundled_scenes(), *FilesCompleter(("toml",))(prefix)]


def names(kind: str) -> Callable[..., list[str]]:
    """A completer of the names of installed parts of a kind; of every kind if it is empty."""

    def found(**_: Any) -> list[str]:
        from contactlab.parts.registry import default_registry

        registry = default_registry()
        return registry.names(kind) if kind else [offer.part.name for offer in registry.parts()]

    return found


def kinds(**_: Any) -> list[str]:
    """Kinds of parts."""
    from contactlab.api.part import KINDS

    return list(KINDS)


def targets(prefix: str, **_: Any) -> list[str]:
    """Return targets of `check`: installed parts, and Python files in the folder."""
    from argcomplete.completers import FilesCompleter

    return [*names("")(), *FilesCompleter(("py",))(prefix)]


def reference_names(prefix: str, **_: Any) -> list[str]:
    """Installed references, and files nearby that could hold one."""
    from argcomplete.completers import FilesCompleter

    return [*names("reference")(), "finest", *FilesCompleter(("json", "csv"))(prefix)]


def settings(prefix: str, parsed_args: argparse.Namespace, **_: Any) -> list[str]:
    """Keys of the scene that was typed before, and behind the sign the parts that fit there."""
    from contactlab.scene.scene import Scene, load_scene

    key, sign, _value = prefix.partition("=")
    if sign:
        from contactlab.parts.registry import default_registry
        from contactlab.scene.fields import kind_at

        kind = kind_at(Scene, key.split("."))
        return [f"{key}={name}" for name in default_registry().names(kind)] if kind else []
    try:
        data = load_scene(getattr(parsed_args, "scene", "") or "disc-on-block").data
    except ContactlabError:
        return []
    return [f"{name}=" for name in keys_in(data)]


def keys_in(value: Any, path: str = "") -> list[str]:
    """Dotted keys of all that is inside, tables before what they hold."""
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    found = [] if not path else [path]
    for name, item in entries:
        if not isinstance(value, list) or isinstance(item, dict):
            found += keys_in(item, f"{path}.{name}" if path else str(name))
    return found
