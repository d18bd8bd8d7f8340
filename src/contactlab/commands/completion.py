"""`contactlab completion`: what a shell needs to complete commands, scenes, parts and keys."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from contactlab.errors import RequestError

SHELLS = ("bash", "zsh", "fish", "powershell")


def completion(options: argparse.Namespace) -> int:
    """Print the lines that switch completion on in a shell."""
    sys.stdout.write(_argcomplete().shellcode(["contactlab"], shell=options.shell))
    return 0


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer the shell, which asks by running the program; ends the process."""
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
        "scene": scene_names, "source": scene_names, "name": part_names, "settings": settings, "vary": settings,
        "cases": case_names, "contacts": contact_names, "files": FilesCompleter(("py",)), "out": DirectoriesCompleter(),
        "kind": kinds, "target": targets, "reference": reference_names, "path": DirectoriesCompleter(),
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


def part_names(**_: Any) -> list[str]:
    """Names of installed parts of every kind."""
    from contactlab.parts.registry import default_registry

    return [offer.part.name for offer in default_registry().parts()]


def kinds(**_: Any) -> list[str]:
    """Kinds of parts."""
    from contactlab.api.part import KINDS

    return list(KINDS)


def targets(prefix: str, **_: Any) -> list[str]:
    """What can be checked: installed parts, and Python files nearby."""
    from argcomplete.completers import FilesCompleter

    return [*part_names(), *FilesCompleter(("py",))(prefix)]


def reference_names(prefix: str, **_: Any) -> list[str]:
    """Installed references, and files nearby that could hold one."""
    from argcomplete.completers import FilesCompleter

    from contactlab.parts.registry import default_registry

    return [*default_registry().names("reference"), "finest", *FilesCompleter(("json", "csv"))(prefix)]


def case_names(**_: Any) -> list[str]:
    """Names of the cases that a matrix can run."""
    from contactlab.parts.registry import default_registry

    return default_registry().names("case")


def contact_names(**_: Any) -> list[str]:
    """Names of the installed contact algorithms."""
    from contactlab.parts.registry import default_registry

    return default_registry().names("contact")


def settings(prefix: str, parsed_args: argparse.Namespace, **_: Any) -> list[str]:
    """Keys of the scene that was typed before, and behind the sign the parts that fit there."""
    from contactlab.errors import ContactlabError
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
