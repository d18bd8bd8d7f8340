"""All parts on offer, by kind and name, and the way from what a scene writes to an instance."""

from __future__ import annotations

import copy
import importlib
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, requires
from pathlib import Path
from typing import Any

from contactlab.api import ExplicitIntegrator
from contactlab.api.part import CONTRACT_VERSION, KINDS, Part, what_to_change
from contactlab.errors import NOTHING, PartError, RequestError, SceneError, Where, below, did_you_mean, one_line, show
from contactlab.parts import contract
from contactlab.parts import loading as plugins
from contactlab.parts.loading import CORE, Broken, Origin, Plugin
from contactlab.parts.scenes_and_commands import KEBAB, commands_of, scenes_of
from contactlab.scene.auto import AUTO, Auto
from contactlab.scene.fields import PartSpec, as_data
from contactlab.scene.reading import read_table

_TARGET = re.compile(r"[\w.-]+:\w+")


@dataclass(frozen=True)
class Offer:
    """A part and the plugin it comes from."""

    part: Part
    origin: Origin


class Registry:
    """The parts, scenes and commands of a set of plugins.

    entry_points  plugins to load; all installed ones by default
    files         Python files with hooks, given by hand
    classes       parts and their classes, given by a program
    """

    def __init__(
        self,
        entry_points: Iterable[EntryPoint] | None = None,
        files: Sequence[Path | str] = (),
        classes: Sequence[tuple[Part, type]] = (),
    ) -> None:
        self._plugins: list[Plugin] = []
        self._broken: list[Broken] = []
        self._offers: dict[tuple[str, str], list[Offer]] = {}
        self.files: tuple[Path, ...] = ()
        self.classes: tuple[tuple[Part, type], ...] = ()
        if entry_points is None:
            entry_points = plugins.installed()
            self._broken += plugins.misplaced()
        for point in entry_points:
            self._add(plugins.load(plugins.origin_of(point), point.load))
        for path in files:
            self.add_file(path)
        for part, target in classes:
            self.add_class(part, target)

    def __reduce__(self) -> tuple[Any, ...]:
        # another process finds the same installed plugins by itself
        hidden = [part.name for part, target in self.classes if target.__module__ == "__main__"]
        if hidden:
            raise PartError(
                "other processes cannot import a class of the running program",
                got=", ".join(hidden),
                hint="write it into a separate file; contactlab.use also takes the file",
            )
        return Registry, (None, self.files, self.classes)

    def add_file(self, path: Path | str) -> None:
        """Register the hooks in a Python file. Raises PartError with all its faults; nothing of it stays then.

        A target in the file itself is written "file_stem:ClassName".
        """
        path = Path(path).resolve()
        if path in self.files:
            return
        refused: list[PartError] = []

        def imported() -> Any:
            try:
                return plugins.file_module(path)
            except PartError as error:
                refused.append(error)
                raise

        origin = Origin(path.stem, str(path))
        loaded = plugins.load(origin, imported)
        if refused:
            raise refused[0]
        before = list(self._plugins), list(self._broken), {key: list(offers) for key, offers in self._offers.items()}
        self._add(loaded)
        wrong = [item for item in self.broken() if item.origin == origin]
        if wrong:
            wrong += self._incomplete_in(path.stem)
            self._plugins, self._broken, self._offers = before
            told = [b.reason if b.item in b.reason else f"{b.item}: {b.reason}" for b in wrong]
            raise PartError(
                told[0] if len(told) == 1 else "\n  ".join([f"{len(told)} errors", *told]),
                where=str(path),
            )
        self.files = (*self.files, path)

    def _incomplete_in(self, module: str) -> list[Broken]:
        """Return the parts of `incomplete` with a class in this module; none if it was not imported."""
        here = self.parts() if module in sys.modules else []
        return _incomplete(offer for offer in here if offer.part.target.partition(":")[0] == module)

    def add_class(self, part: Part, target: type) -> None:
        """Register a class of the running program. Raises PartError if it does not keep the contract."""
        wrong = _fault_of(part) or "; ".join(contract.faults(part.kind, target))
        if wrong:
            raise PartError(f"{target.__name__} cannot be used: {wrong}", where=target.__module__, got=part.name)
        others = [(known, its) for known, its in self.classes if known != part]
        if len(others) == len(self.classes) and self._offers.get((part.kind, part.name)):
            raise PartError(f"there is a {part.kind} of this name already", where=target.__module__, got=part.name)
        self._offers[part.kind, part.name] = [Offer(part, Origin(target.__module__, "this program"))]
        self.classes = (*others, (part, target))  # a cell of a notebook that is run again redefines the class

    def _add(self, loaded: Plugin | Broken) -> None:
        if isinstance(loaded, Broken):
            self._broken.append(loaded)
            return
        self._plugins.append(loaded)
        offered = plugins.call(loaded, "contactlab_parts")
        if isinstance(offered, Broken):
            self._broken.append(offered)
            return
        if not offered and loaded.hooks.contactlab_parts.get_hookimpls():  # pluggy leaves None out
            self._add_parts(loaded.origin, None)
        for parts in offered:
            self._add_parts(loaded.origin, parts)

    def _add_parts(self, origin: Origin, parts: Any) -> None:
        if isinstance(parts, Part) or not isinstance(parts, Iterable):
            reason = f"contactlab_parts gave {type(parts).__name__}; allowed: a list of Part"
            self._broken.append(Broken(origin, reason))
            return
        for part in parts:
            reason = _fault_of(part)
            if reason:
                self._broken.append(Broken(origin, reason, item=_label(part)))
            else:
                self._offers.setdefault((part.kind, part.name), []).append(Offer(part, origin))

    def parts(self) -> list[Offer]:
        """All usable parts, ordered by kind and name."""
        single = [offers[0] for offers in self._offers.values() if len(offers) == 1]
        return sorted(single, key=lambda offer: (KINDS.index(offer.part.kind), offer.part.name))

    def names(self, kind: str) -> list[str]:
        """The names of the parts of one kind."""
        return [offer.part.name for offer in self.parts() if offer.part.kind == kind]

    def broken(self) -> list[Broken]:
        """Everything that was left out, with the reason."""
        named = (scenes_of(self._plugins), commands_of(self._plugins))
        return [*self._broken, *self._duplicates(), *(item for kind in named for item in kind.broken)]

    def reason_against(self, item: str) -> str:
        """Return what to fix if "scene NAME" or "command NAME" was left out; empty if none was offered."""
        return "; ".join(f"fix {broken.origin}: {broken.reason}" for broken in self.broken() if broken.item == item)

    def _duplicates(self) -> list[Broken]:
        found = []
        for (kind, name), offers in self._offers.items():
            for offer in offers if len(offers) > 1 else []:
                reason = f"the {kind} {name} is offered more than once: {_origins(offers)}; none of them is used"
                found.append(Broken(offer.origin, reason, item=f"{kind} {name}"))
        return found

    def burdens(self) -> list[Broken]:
        """Plugins that work, and what every command suffers from them: slow or printing imports."""
        return [Broken(plugin.origin, burden) for plugin in self._plugins for burden in plugin.burdens]

    def incomplete(self) -> list[Broken]:
        """Parts whose class cannot be imported or does not keep the contract. Imports every target."""
        return _incomplete(self.parts())

    def offer(self, kind: str, name: str, where: Where = "") -> Offer:
        """The part of this kind and name. Raises PartError with the nearest name if there is none."""
        offers = self._offers.get((kind, name), [])
        if len(offers) > 1:
            raise PartError(
                f"the {kind} {name} is offered more than once: {_origins(offers)}",
                where=where,
                got=name,
                hint=f"uninstall one of them, or name the plugins to load in {plugins.RESTRICT}",
            )
        if not offers:
            raise self._unknown(kind, name, where)
        return offers[0]

    def _unknown(self, kind: str, name: str, where: Where) -> PartError:
        names = [*self.names(kind), *([AUTO] if kind == "integrator" else [])]
        return PartError(
            f"no {kind} of this name is installed",
            where=where,
            got=name,
            allowed=", ".join(names) if names else f"no {kind} is installed at all",
            hint=self.missing_from(name) or did_you_mean(name, names) or self._other_reason(name),
        )

    def _other_reason(self, name: str) -> str:
        kinds = [kind for kind in KINDS if name in self.names(kind)]
        if kinds:
            return f"{name} is of kind {' and '.join(kinds)}"
        broken = sorted({str(item.origin) for item in self.broken()})
        if broken:
            return f"contactlab parts (plugins that could not be loaded: {', '.join(broken)})"
        return "install the plugin that has it; contactlab parts lists all installed parts"

    def missing_from(self, name: str) -> str:
        """Return what to install for a part of a usual plugin, or for that plugin; empty if none is known."""
        bringing = [p for p in self.missing_packages() if name in (p, *known_packages()[p])]
        if not bringing:
            return ""
        hidden = os.environ.get(plugins.RESTRICT)
        also = f", or unset {plugins.RESTRICT}, which allows {hidden} only" if hidden else ""
        return f"{bringing[0]} has it: pip install {bringing[0]}{also}"

    def missing_packages(self, optional: bool = True) -> list[str]:
        """Plugins of this repository that are not installed; without the `optional` ones, those the core requires."""
        here = {plugin.origin.distribution for plugin in self._plugins}
        missing = [package for package in known_packages() if package not in here]
        needs = " ".join(line for line in requires(CORE) or () if "extra ==" not in line)
        return [package for package in missing if optional or package in needs]

    def part_class(self, kind: str, name: str, where: Where = "") -> type[Any]:
        """The class of a part, imported now and checked against the contract.

        Raises PartError if the part is unknown, cannot be imported or is incomplete.
        """
        offer = self.offer(kind, name, where)
        try:
            return _checked_class(offer)
        except PartError as error:
            message = f"the {kind} {name} cannot be used: {error.problem}"
            others = [
                b for b in self._incomplete_in(offer.part.target.partition(":")[0]) if b.item != _label(offer.part)
            ]
            also = "".join(f"; also its {b.item}: {b.reason}" for b in others)
            raise PartError(message, where=where, hint=f"fix or update {error.where}{also}") from error

    def make(self, kind: str, spec: Any, where: Where = "") -> Any:
        """An instance of the part that `spec` names: a string, or a table with `use` and fields.

        Raises PartError for the part, SceneError for its fields.
        """
        name, fields = split_spec(kind, spec, where)
        target = self.part_class(kind, name, where)
        try:
            return read_table(target, fields, where, self.written_out)
        except RequestError:
            raise
        except Exception as error:
            offer = self.offer(kind, name)
            reason = f"the {kind} {name} of {offer.origin} failed on its fields: {one_line(error)}"
            raise PartError(reason, where=where, got=fields) from error

    def written_out(self, kind: str, spec: Any, where: Where = "") -> PartSpec:
        """`spec` as a table with `use` and every field, defaults included; checked like `make`.

        An integrator may be `auto`: no part, but the order in which integrators are tried.
        """
        name, fields = split_spec(kind, spec, where)
        if (kind, name) == ("integrator", AUTO):
            fields = {"order": usual_order(self), **fields}
            return {"use": AUTO, **as_data(read_table(Auto, fields, where, self.written_out))}
        return {"use": name, **as_data(self.make(kind, spec, where))}

    def scenes(self) -> dict[str, Path]:
        """Paths of the scenes that plugins bring, by name; `broken` lists the scenes left out."""
        return {name: Path(path) for name, (path, _) in scenes_of(self._plugins).usable.items()}

    def commands(self) -> dict[str, tuple[str, Origin]]:
        """Further commands by name: "module:function" and its origin; `broken` lists the commands left out."""
        return commands_of(self._plugins).usable

    def packages(self) -> dict[str, Origin]:
        """Import names of the packages, or modules, that plugins and their parts lie in, and whose they are."""
        found = {plugin.module.partition(".")[0]: plugin.origin for plugin in self._plugins}
        for offers in self._offers.values():
            for offer in offers:
                found.setdefault(re.split("[.:]", offer.part.target, maxsplit=1)[0], offer.origin)
        return found

    def run_finished(self, summary: Mapping[str, Any], folder: Path | None) -> list[Broken]:
        """Call the hook of every plugin at the end of a run; return those that raised."""
        told = [plugin for plugin in self._plugins if plugin.hooks.contactlab_run_finished.get_hookimpls()]
        # a copy for each: a plugin that writes into it changes neither the result nor the input of the next
        copies = [(plugin, copy.deepcopy(dict(summary))) for plugin in told]
        answers = [plugins.call(p, "contactlab_run_finished", summary=own, folder=folder) for p, own in copies]
        return [answer for answer in answers if isinstance(answer, Broken)]


@cache
def known_packages() -> dict[str, list[str]]:
    """Packages of this repository, installed or not, and the names of the parts of each."""
    import json

    path = Path(__file__).parents[1] / "data" / "known_parts.json"
    known: dict[str, list[str]] = json.loads(path.read_text(encoding="utf-8"))
    return known


@cache
def default_registry() -> Registry:
    """The registry of the installed plugins, loaded once in a process."""
    return Registry()


def usual_order(registry: Registry) -> list[str]:
    """Names of the integrators that are tried if a scene gives no order: statics, implicit, explicit."""
    kinds = {name: registry.part_class("integrator", name) for name in registry.names("integrator")}
    usual = [name for name, kind in kinds.items() if kind.by_default]
    return sorted(usual, key=lambda name: (kinds[name].inertia, issubclass(kinds[name], ExplicitIntegrator)))


def split_spec(kind: str, spec: Any, where: Where) -> tuple[str, dict[str, Any]]:
    """Name and fields of a part as a scene writes it."""
    allowed = f"the name of a part of kind {kind}, or {{ use = NAME, ... }}"
    if isinstance(spec, str):
        return spec, {}
    if not isinstance(spec, Mapping):
        raise SceneError(f"a {kind} is named here", where=where, got=spec, allowed=allowed)
    fields = {str(name): value for name, value in spec.items()}
    name = fields.pop("use", NOTHING)
    if name is NOTHING:
        hint = "did you mean " + show({"use": "NAME", **fields}) + "?"
        raise SceneError('the key "use" is missing', where=where, got=spec, allowed=allowed, hint=hint)
    if not isinstance(name, str):
        raise SceneError(f"a {kind} is named here", where=below(where, "use"), got=name, allowed=allowed)
    return name, fields


def _fault_of(part: Any) -> str:
    if not isinstance(part, Part):
        return f"contactlab_parts lists {type(part).__name__}; allowed: Part"
    return "; ".join(_faults_of(part))


def _faults_of(part: Part) -> Iterator[str]:
    if part.api != CONTRACT_VERSION:
        yield (
            f"it is written for version {part.api} of the contract, this is version {CONTRACT_VERSION}; to change: "
            f"{what_to_change(str(part.kind), part.api)}"
        )
    if part.kind not in KINDS:
        hint = did_you_mean(str(part.kind), KINDS)
        yield f'there is no kind "{part.kind}"; allowed: {", ".join(KINDS)}' + (f"; {hint}" if hint else "")
    if not isinstance(part.name, str) or not KEBAB.fullmatch(part.name):
        yield f'the name "{part.name}" is not lower-case words joined by -'
    if (part.kind, part.name) == ("integrator", AUTO):
        yield f'an integrator cannot be called "{AUTO}": scenes leave the choice to the run by this word'
    if not isinstance(part.target, str) or not _TARGET.fullmatch(part.target):
        yield f'the target "{part.target}" is not of the form package.module:ClassName'


def _incomplete(offers: Iterable[Offer]) -> list[Broken]:
    """Return offers whose class cannot be imported or does not keep the contract."""
    found = []
    for offer in offers:
        try:
            _checked_class(offer)
        except PartError as error:
            found.append(Broken(offer.origin, error.problem, item=_label(offer.part)))
    return found


def _label(part: Any) -> str:
    return f"{part.kind} {part.name}" if isinstance(part, Part) else ""


def _origins(offers: Sequence[Offer]) -> str:
    return " and ".join(f"{offer.origin} ({offer.part.target})" for offer in offers)


def _checked_class(offer: Offer) -> type:
    """The target, imported and checked. The error's place is the distribution at fault."""
    module_name, _, class_name = offer.part.target.partition(":")
    where = str(offer.origin)
    try:
        target = getattr(importlib.import_module(module_name), class_name, NOTHING)
    except (Exception, SystemExit) as error:
        raise PartError(f"{module_name} cannot be imported: {one_line(error)}", where=where) from error
    if target is NOTHING:
        raise PartError(f"{module_name} has no {class_name}", where=where)
    wrong = contract.faults(offer.part.kind, target)
    if wrong:
        raise PartError(f"{offer.part.target} is incomplete: {'; '.join(wrong)}", where=where)
    assert isinstance(target, type)
    return target
