"""Loading plugins, each under its own guard: a broken one is named and stops nothing else."""

from __future__ import annotations

import importlib.util
import io
import os
import re
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any

import pluggy

from contactlab.api.part import MOVED_IN_2
from contactlab.errors import MISSPELT, PartError, RequestError, did_you_mean, one_line
from contactlab.parts import hookspecs

GROUP = hookspecs.PROJECT
CORE = "contactlab"
RESTRICT = "CONTACTLAB_PLUGINS"
SLOW_CPU, SLOW = 0.3, 2.0
"""Seconds of CPU and of the clock beyond which an import is called slow: every command waits for it."""


@dataclass(frozen=True)
class Origin:
    """Origin of a plugin: the entry point's name, its distribution and version.

    A file given by hand is its own distribution.
    """

    plugin: str
    distribution: str
    version: str = ""

    def __str__(self) -> str:
        return f"{self.distribution} {self.version}".strip()


@dataclass(frozen=True)
class Broken:
    """A plugin, or one thing of a plugin (`item`), that is left out, and why."""

    origin: Origin
    reason: str
    item: str = ""


@dataclass(frozen=True)
class Plugin:
    """A loaded plugin: where it comes from, its hooks, the name of the module that has them, and what every command
    suffers from its import."""

    origin: Origin
    hooks: Any
    module: str
    burdens: tuple[str, ...] = ()


def installed(group: str = GROUP) -> list[EntryPoint]:
    """Entry points of all installed plugins that `CONTACTLAB_PLUGINS` lets through, the core's first."""
    found = sorted(entry_points(group=group), key=lambda point: (not _core(point), point.name))
    wanted = [name.strip() for name in os.environ.get(RESTRICT, "").split(",") if name.strip()]
    if not wanted:
        return found
    names = {name for point in found for name in (point.name, _distribution(point))}
    for name in wanted:
        if _same(name) not in {_same(other) for other in names}:
            raise RequestError(
                "no such plugin is installed",
                where=f"environment variable {RESTRICT}",
                got=name,
                allowed=", ".join(sorted(names)),
                hint=did_you_mean(name, names),
            )
    keep = {_same(name) for name in wanted}
    return [point for point in found if _core(point) or {_same(point.name), _same(_distribution(point))} & keep]


def misplaced() -> list[Broken]:
    """Entry points in a group whose name misses this program's by a letter or two."""
    if os.environ.get(RESTRICT):
        return []
    near = [g for g in entry_points().groups if g != GROUP and get_close_matches(g, [GROUP], cutoff=MISSPELT)]
    return [
        Broken(origin_of(point), f'its entry point is in the group "{group}"; allowed: "{GROUP}"')
        for group in sorted(near)
        for point in entry_points(group=group)
    ]


def _core(point: EntryPoint) -> bool:
    return _distribution(point) == CORE


def _same(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _distribution(point: EntryPoint) -> str:
    return point.dist.name if point.dist is not None else "unknown distribution"


def origin_of(point: EntryPoint) -> Origin:
    """The origin of what an entry point offers."""
    return Origin(point.name, _distribution(point), point.dist.version if point.dist is not None else "")


def load(origin: Origin, importer: Callable[[], Any]) -> Plugin | Broken:
    """Import and register one plugin; what goes wrong becomes a reason. What it prints goes to stderr."""
    printed, cpu, clock = io.StringIO(), time.process_time(), time.perf_counter()
    try:
        # programs read stdout: a greeting there breaks --json
        with redirect_stdout(printed):
            module = importer()
    except (Exception, SystemExit) as error:
        return Broken(origin, f"its import failed: {one_line(error)}{_moved(error)}")
    burdens = _burdens(time.process_time() - cpu, time.perf_counter() - clock, printed.getvalue())
    try:
        hooks = _register(module)
        return Plugin(origin, hooks, getattr(module, "__name__", type(module).__module__), burdens)
    except Exception as error:
        return Broken(origin, one_line(error, name=False))


def _burdens(cpu: float, clock: float, printed: str) -> tuple[str, ...]:
    """Cost of an import for every command: time [s], and output, which is passed on to stderr."""
    found = []
    if cpu > SLOW_CPU or clock > SLOW:
        found.append(
            f"its import takes {clock:.1f} s ({cpu:.1f} CPU s), which delays every command; import slow modules in "
            "the functions that need them, and name parts by strings"
        )
    if printed:
        sys.stderr.write(printed)
        first = printed.strip().partition("\n")[0]
        found.append(f"its import prints {first[:60]!r}; it goes to stderr")
    return tuple(found)


def _register(module: object) -> Any:
    # a manager per plugin: what pluggy refuses in one then cannot touch another
    manager = _manager()
    hooks = {
        name: impl["specname"] or name for name in dir(module) if (impl := manager.parse_hookimpl_opts(module, name))
    }
    wrong = [*_wrong_hooks(module, hooks), *_unmarked(module, hooks)]
    if not hooks and not wrong and isinstance(module, ModuleType):
        wrong = [RequestError(f"{module.__name__} implements no hook", allowed=", ".join(_hook_names()))]
    if wrong:
        raise RequestError("; ".join(one_line(error, name=False) for error in wrong))
    manager.register(module)
    return manager.hook


def _manager() -> pluggy.PluginManager:
    manager = pluggy.PluginManager(hookspecs.PROJECT)
    manager.add_hookspecs(hookspecs)
    return manager


def _hook_names() -> list[str]:
    return [name for name in vars(hookspecs) if name.startswith(f"{hookspecs.PROJECT}_")]


def _wrong_hooks(module: object, hooks: Mapping[str, str]) -> Iterator[Exception]:
    """Marked functions, given with the hook that each is for, that are no hook or have other arguments."""
    choices = _hook_names()
    for function, hook in hooks.items():
        if hook not in choices:
            yield RequestError(f"unknown hook {hook}", allowed=", ".join(choices), hint=did_you_mean(hook, choices))
            continue
        try:
            # each alone: pluggy stops at the first that it refuses
            _manager().register(SimpleNamespace(**{function: getattr(module, function)}), name=str(module))
        except pluggy.PluginValidationError as error:
            yield error


def _unmarked(module: object, hooks: Mapping[str, str]) -> Iterator[Exception]:
    """Functions with the name of a hook that lack its mark."""
    for name, value in vars(module).items() if isinstance(module, ModuleType) else ():
        own = isinstance(value, FunctionType) and value.__module__ == getattr(module, "__name__", "")
        if own and name.startswith(f"{hookspecs.PROJECT}_") and name not in hooks:
            yield RequestError(f"{name} is not marked as a hook", hint="write @hookimpl above it")


def call(plugin: Plugin, hook: str, **arguments: Any) -> list[Any] | Broken:
    """The results of one hook of one plugin; an exception becomes a reason, one of a generator as well."""
    try:
        answers = getattr(plugin.hooks, hook)(**arguments)
        return [list(answer) if isinstance(answer, Iterator) else answer for answer in answers]
    except (Exception, SystemExit) as error:
        return Broken(plugin.origin, f"{hook} raised {one_line(error)}", item=hook)


def file_module(path: Path) -> ModuleType:
    """The module in a file given by hand, importable by its stem from then on.

    Raises PartError if there is no such file, its name is taken or its import fails.
    """
    where = str(path)
    if not path.is_file():
        raise PartError("there is no such file", where=where, allowed="a Python file with a contactlab_parts hook")
    if path.suffix != ".py":
        raise PartError("not a Python file", where=where, allowed="a file named NAME.py")
    _refuse_taken(path)
    specification = importlib.util.spec_from_file_location(path.stem, path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    # before the import: dataclasses look their own module up, and targets name it
    sys.modules[path.stem] = module
    try:
        specification.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[path.stem]
        raise PartError(
            f"its import failed: {one_line(error)}{_line(error, path)}{_moved(error)}", where=where
        ) from error
    return module


def _refuse_taken(path: Path) -> None:
    place = None
    if path.stem in sys.modules:
        place = getattr(sys.modules[path.stem], "__file__", None) or "the interpreter"
    elif path.stem.isidentifier() and (other := importlib.util.find_spec(path.stem)):
        place = other.origin or "a folder of this name"
    if place and Path(place).resolve() != path:
        raise PartError(
            "another module has this name", where=str(path), got=f"name used by {place}", hint="rename the file"
        )


def _moved(error: BaseException) -> str:
    """Return where a module or name of version 1 of the contract is now; empty for other errors."""
    if not isinstance(error, ImportError):
        return ""
    name = re.search(r"cannot import name '(\w+)'", str(error))
    old = name[1] if name else error.name or ""
    return f"; in version 2 of the contract it is {MOVED_IN_2[old]}" if old in MOVED_IN_2 else ""


def _line(error: BaseException, path: Path) -> str:
    """Return the line of the file where the import stopped, in words."""
    if isinstance(error, SyntaxError):
        return ""
    import traceback

    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename) == path]
    return f" (line {lines[-1]})" if lines else ""
