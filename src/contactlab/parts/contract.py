"""Checks that a class can serve as a part of its kind."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator
from difflib import get_close_matches
from typing import get_args
from weakref import WeakKeyDictionary

from contactlab.api.case import Case
from contactlab.api.contact import ContactAlgorithm, ContactMethod, GapAlgorithm
from contactlab.api.effect import Effect
from contactlab.api.element import Element
from contactlab.api.enforcement import Enforcement, ExplicitEnforcement, ImplicitEnforcement
from contactlab.api.friction import FrictionLaw, FrictionNeed
from contactlab.api.function import Function
from contactlab.api.integrator import ExplicitIntegrator, ImplicitIntegrator, Integrator
from contactlab.api.material import Material
from contactlab.api.measure import RunMeasure
from contactlab.api.mesh import MeshSource
from contactlab.api.normal_law import NormalLaw, NormalNeed
from contactlab.api.part import INSTEAD, NEW_IN_2
from contactlab.api.potential import Potential
from contactlab.api.recorder import Recorder
from contactlab.api.reference import ReferenceSolution
from contactlab.api.watch import Watch
from contactlab.errors import MISSPELT
from contactlab.parts.declared_values import wrong_values

BASES: dict[str, tuple[type, ...]] = {
    "element": (Element,),
    "material": (Material,),
    "mesh": (MeshSource,),
    "contact": (ContactAlgorithm, GapAlgorithm, Potential),
    "friction": (FrictionLaw,),
    "enforcement": (ExplicitEnforcement, ImplicitEnforcement, NormalLaw),
    "integrator": (ExplicitIntegrator, ImplicitIntegrator),
    "effect": (Effect,),
    "function": (Function,),
    "recorder": (Recorder,),
    "watch": (Watch,),
    "case": (Case,),
    "measure": (RunMeasure,),
    "reference": (ReferenceSolution,),
}
"""The classes of `contactlab.api` that a part of each kind derives from."""

_SOUND: WeakKeyDictionary[type, set[str]] = WeakKeyDictionary()
"""Kinds for which a class passed the checks: a run checks a hundred times, and a check takes 2 ms."""


def faults(kind: str, target: object) -> list[str]:
    """Everything that keeps `target` from being a part of `kind`; empty when it is one."""
    if isinstance(target, type) and kind in _SOUND.get(target, ()):
        return []
    found = _faults(kind, target)
    if not found and isinstance(target, type):
        _SOUND.setdefault(target, set()).add(kind)
    return found


def _faults(kind: str, target: object) -> list[str]:
    bases = BASES[kind]
    allowed = " or ".join(f"contactlab.api.{base.__name__}" for base in bases)
    if not isinstance(target, type):
        return [f"it is not a class but {type(target).__name__}; allowed: a subclass of {allowed}"]
    if not issubclass(target, bases):
        older = issubclass(target, Integrator)  # which parts of version 1 derived from
        return [f"it does not derive from {allowed}{'; to change: ' + NEW_IN_2['integrator'] if older else ''}"]
    if target in (*bases, ContactMethod, Enforcement, Integrator):
        return ["it is the abstract class of the contract itself"]
    return [
        *_missing_methods(target), *_missing_attributes(target),
        *(wrong_values(target) or _memory_without_use(target) or _other_arguments(target)),
        *_unread(target), *_misspelt(target), *_replaced(target), *_not_a_record(target),
    ]  # fmt: skip


def _replaced(target: type) -> list[str]:
    """Names that nothing reads any more, where parts written before would go wrong in silence."""
    names = INSTEAD if issubclass(target, Enforcement) else {}
    return [f"it has {name}, which is not read; to change: {names[name]}" for name in names if hasattr(target, name)]


def _missing_methods(target: type) -> list[str]:
    missing = sorted(getattr(target, "__abstractmethods__", ()))
    if issubclass(target, Integrator) and not {"step", "bind"} & {*_own_names(target)}:
        missing.append("step")
    return [f"it has no {', '.join(missing)}"] if missing else []


def _own_names(target: type) -> Iterator[str]:
    """Names that a part and its bases outside the contract define."""
    for base in target.__mro__:
        if not base.__module__.startswith(("contactlab.api.", "builtins")):
            yield from vars(base)


def _missing_attributes(target: type) -> list[str]:
    """Names that a base class annotates and that nothing gives a value."""
    promised: dict[str, bool] = {}
    for base in reversed(target.__mro__):
        if base.__module__.startswith("contactlab.api."):
            promised |= {name: "ClassVar" in str(hint) for name, hint in inspect.get_annotations(base).items()}
    fields = set(getattr(target, "__dataclass_fields__", ()))
    classwide = [name for name, of_class in promised.items() if of_class and not hasattr(target, name)]
    own = [name for name, of_class in promised.items() if not of_class and name not in fields]
    texts = [f"it does not set the class attribute {', '.join(classwide)}"] if classwide else []
    return texts + ([f"it has no field {', '.join(own)}"] if own else [])


def _other_arguments(target: type) -> list[str]:
    """Methods that cannot be called as the contract calls them."""
    found = []
    for base in (base for base in target.__mro__ if base.__module__.startswith("contactlab.api.")):
        for name, method in vars(base).items():
            own = inspect.getattr_static(target, name)
            if not inspect.isfunction(method) or name.startswith("_") or not inspect.isfunction(own):
                continue
            if inspect.unwrap(own) is method:  # the contract's own, or made of a formula
                continue
            given = {p.name: p for p in inspect.signature(method).parameters.values()}
            named = {n: None for n, p in given.items() if p.kind is p.KEYWORD_ONLY}
            if any(p.kind is p.VAR_KEYWORD for p in given.values()):  # what the part declares, by name
                fixed = {n: p for n, p in given.items() if p.kind is p.POSITIONAL_OR_KEYWORD}
                named = dict.fromkeys((*target.needs, *target.memory))  # type: ignore[attr-defined]
                if issubclass(target, NormalLaw) and "traction" in target.needs:
                    fixed |= dict.fromkeys(("traction", "by_traction") if name == "pressure" else (), given["self"])
                    named = {}
                if issubclass(target, NormalLaw) and name == "evolve":
                    named |= dict.fromkeys(("gap", "pressure", "stiffness", "size"))
                given = fixed | dict.fromkeys(named, given["self"])
            try:
                inspect.signature(own).bind(*(None for n in given if n not in named), **named)
            except TypeError:
                taken = ", ".join(inspect.signature(own).parameters)
                found.append(f"its {name} takes ({taken}); it is called with ({', '.join(given)})")
    return found


def _memory_without_use(target: type) -> list[str]:
    """Memory of a law that nothing changes, or that has the name of something else."""
    if not issubclass(target, FrictionLaw | NormalLaw) or not target.memory:
        return []
    base, needs = (FrictionLaw, FrictionNeed) if issubclass(target, FrictionLaw) else (NormalLaw, NormalNeed)
    found = [] if target.evolve is not base.evolve else ["it has memory but no evolve to update it"]
    names = {*get_args(needs), *target.needs}
    taken = [name for name in target.memory if name in names or target.memory.count(name) > 1]
    return found + ([f"its memory is {target.memory}; allowed: names that differ, and none of needs"] if taken else [])


def _unread(target: type) -> list[str]:
    """Needs or memory, tuples of names, that nothing reads from a part of this kind."""
    found = [
        f"its {name} is not read from a part of this kind; allowed: {_INSTEAD.get((base, name), 'none')}"
        for name in ("needs", "memory")
        for base in target.__mro__
        if base in _BASES and not hasattr(base, name) and isinstance(getattr(target, name, None), tuple)
    ]
    refused = next((names for base, names in _REFUSED.items() if issubclass(target, base)), {})
    needs = getattr(target, "needs", ()) if refused else ()
    return found + [
        f"its needs name {name}; allowed: other names; {refused[name]}" for name in needs if name in refused
    ]


_BASES = tuple(base for bases in BASES.values() for base in bases)
_REFUSED: dict[type, dict[str, str]] = {
    Effect: {
        **dict.fromkeys(("time", "dt"), "the function of bind is called with it"),
        **dict.fromkeys(("position", "cell_size"), "the view has positions, and shares of nodes"),
        **dict.fromkeys(("pressure", "slip_rate", "traction"), "contact answers forces of effects in the same step"),
    },
    Material: {
        "dt": "it is always given",
        **dict.fromkeys(("pressure", "traction"), "the law itself gives the stress"),
        "slip_rate": "surfaces slip, not the points of a body",
    },
}  # fmt: skip
"""Names that are no field of a scene, and that parts of a kind have otherwise or cannot have."""
_LAWS = ", and what its methods are given; friction and pressure laws may need more"
_INSTEAD: dict[tuple[type, str], str] = {
    (ExplicitEnforcement, "needs"): "what rows have" + _LAWS,
    (ImplicitEnforcement, "needs"): "what conditions have" + _LAWS,
    (ContactAlgorithm, "needs"): "the view" + _LAWS, (GapAlgorithm, "needs"): "the view" + _LAWS,
    (Potential, "needs"): "positions" + _LAWS,
    (Element, "needs"): "what its methods are given; materials and effects may need more",
    (Material, "memory"): "history_names and history_size",
    (ContactAlgorithm, "memory"): "memory_size", (GapAlgorithm, "memory"): "memory_size",
}  # fmt: skip


def _misspelt(target: type) -> list[str]:
    """Class attributes and methods that the contract does not know, and whose names miss one that it knows by a letter.

    Nothing would ever read them: the part would promise, or do, nothing of what its author meant.
    """
    known: set[str] = set()
    for base in (base for base in target.__mro__ if base.__module__.startswith("contactlab.api.")):
        known |= {name for name in (*vars(base), *inspect.get_annotations(base)) if not name.startswith("_")}
    keys = dataclasses.fields(target) if dataclasses.is_dataclass(target) else ()
    fields, found = {field.name for field in keys}, []
    for base in (base for base in target.__mro__ if not base.__module__.startswith(("contactlab.api.", "builtins"))):
        for name in {*vars(base), *inspect.get_annotations(base)} - fields - known:
            near = [] if name.startswith("_") else get_close_matches(name, known, 1, MISSPELT)
            if near and near[0] not in vars(base):
                found.append(f"its {name} is not known to the contract; did you mean {near[0]}?")
    return sorted(found)


def _not_a_record(target: type) -> list[str]:
    settings = target.__dict__.get("__dataclass_params__")
    if settings is None or not dataclasses.is_dataclass(target):
        return ["it is not a dataclass; write @dataclass(frozen=True) above it"]
    return [] if settings.frozen else ["it is not frozen; write @dataclass(frozen=True) above it"]
