"""Scenes and commands that plugins offer by name: which can be used, and which are left out, and why."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contactlab.parts import loading as plugins
from contactlab.parts.loading import Broken, Origin, Plugin

KEBAB = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
CORE_COMMANDS = (
    "run", "compare", "matrix", "archive", "view", "explain", "scenes", "new-scene", "new-plugin", "parts", "check",
    "doctor", "completion", "choose", "error-budget", "runs", "plot", "cite",
)  # fmt: skip
"""Commands of the core, whose names no plugin can take."""
_FUNCTION = re.compile(r"[\w.-]+:\w+")


@dataclass(frozen=True)
class Named:
    """Offers of plugins by name through a hook: usable values with their origin, and what is left out."""

    usable: dict[str, tuple[Any, Origin]]
    broken: list[Broken]


def scenes_of(loaded: Iterable[Plugin]) -> Named:
    """The paths of scenes by name."""
    return _named(loaded, "contactlab_scenes", "scene", core_scenes(), _fault_of_path)


def commands_of(loaded: Iterable[Plugin]) -> Named:
    """The functions of further commands by name, as "module:function"."""
    return _named(loaded, "contactlab_commands", "command", CORE_COMMANDS, _fault_of_function)


def core_scenes() -> dict[str, Path]:
    """Paths of the core's own scenes by name."""
    folder = Path(__file__).parents[1] / "data" / "scenes"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def _named(
    loaded: Iterable[Plugin], hook: str, what: str, taken: Collection[str], fault_of: Callable[[Any], str]
) -> Named:
    offers: dict[str, list[tuple[Any, Origin]]] = {}
    broken: list[Broken] = []
    for plugin in loaded:
        for answer in _answers(plugin, hook):
            if isinstance(answer, Broken):
                broken.append(answer)
                continue
            name, value = answer
            if reason := _fault_of_name(name, what, taken) or fault_of(value):
                broken.append(Broken(plugin.origin, reason, item=f"{what} {name}"))
            else:
                offers.setdefault(name, []).append((value, plugin.origin))
    for name, several in offers.items():
        origins = " and ".join(str(origin) for _, origin in several)
        reason = f"the {what} {name} is offered more than once: {origins}; none of them is used"
        broken += [Broken(origin, reason, item=f"{what} {name}") for _, origin in several if len(several) > 1]
    return Named({name: several[0] for name, several in offers.items() if len(several) == 1}, broken)


def _answers(plugin: Plugin, hook: str) -> Iterator[tuple[Any, Any] | Broken]:
    """Names and values that the hook gives, or why it gives none."""
    answer = plugins.call(plugin, hook)
    if isinstance(answer, Broken):
        yield answer
        return
    for table in answer:
        if isinstance(table, Mapping):
            yield from table.items()
        else:
            yield Broken(plugin.origin, f"{hook} gave {type(table).__name__}, not a table of names", item=hook)


def _fault_of_name(name: Any, what: str, taken: Collection[str]) -> str:
    if not isinstance(name, str) or not KEBAB.fullmatch(name):
        return f'the name "{name}" is not lower-case words joined by -'
    return f'the core has a {what} "{name}", which has priority; use another name' if name in taken else ""


def _fault_of_path(path: Any) -> str:
    if not isinstance(path, str | os.PathLike):
        return f"its path is {type(path).__name__}; allowed: the path of a TOML file"
    if not Path(path).is_absolute():
        return f'the path "{path}" depends on the working folder; write Path(__file__).parent / "{path}"'
    return "" if Path(path).is_file() else f'there is no file "{path}"'


def _fault_of_function(target: Any) -> str:
    usable = isinstance(target, str) and _FUNCTION.fullmatch(target)
    return "" if usable else f'the target "{target}" is not of the form package.module:function'
