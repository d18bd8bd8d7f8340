"""`contactlab explain`: what a scene calls for and what it does not."""

from __future__ import annotations

import argparse
import dataclasses
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from contactlab.commands.common import console, number, parse_settings, print_json, registry_with
from contactlab.commands.effect_costs import EffectPrice, effect_costs
from contactlab.explanation.estimate import Estimate
from contactlab.explanation.explain import Explanation, Overview
from contactlab.explanation.explain import explain as explanation_of
from contactlab.explanation.kept import kept, trials, tried
from contactlab.reports.sheet import Column, Sheet, facts
from contactlab.run.attempts import first_that_fits
from contactlab.scene.scene import load_scene
from contactlab.studies.removable import variants

NOTHING = 0.005  # of the cost of a run: a cost that is printed as 0
SHORTENED = 0.9  # of the stable step of the bodies: usual steps are as long, and effects make them shorter
KEY = re.compile(r"(?P<table>[a-z]+)\.(?P<name>[\w-]+)(\.(?P<rest>[\w.]+))?")


def explain(options: argparse.Namespace) -> int:
    """Print the explanation of the scene; but for a trial, which is kept, nothing is run."""

    registry = registry_with(options.files)
    scene = load_scene(options.scene, registry, parse_settings(options.settings))
    scene, order = first_that_fits(scene, registry)
    with trials() as archive:
        explanation = explanation_of(scene, registry, tried(scene, archive), order)
        assert explanation.price is not None
        made = partial(tried if options.effects else kept, archive=archive)
        costs = list(effect_costs(scene, explanation.price, made))
    spare = [variant.effect for variant in variants(scene) if variant.declared]
    shown = console()
    if options.json:
        price = {**dataclasses.asdict(explanation.price), "effects": [dataclasses.asdict(cost) for cost in costs]}
        print_json({"format": 1, **plain(explanation), "can_be_left_out": spare, "price": price})
    elif options.everything:
        for title, content in plain(explanation).items():
            shown.print(section(title.replace("_", " "), content))
        shown.print(section("cost of effects", costs))
    else:
        command = shlex.join([options.scene, *(word for text in options.settings for word in ("--set", text))])
        shown.print(overview(explanation, spare, command, dict(price_lines(explanation.price, costs))))
    return 0


def price_lines(price: Estimate, costs: Sequence[EffectPrice]) -> Iterator[tuple[str, str]]:
    """Yield the cost of the whole run, the share of its effects, and the cost of further effects."""
    if price.reason:
        yield "cost estimate", f"its trial ended {price.reason}"
        return
    of = f"{number(round(price.steps))} steps"
    if price.iterations:
        of += f", {number(round(price.iterations))} iterations"
    interval = f"{seconds(price.least_s)} to {seconds(price.most_s)}"
    yield "cost estimate", f"{seconds(price.cpu_s)} s ({interval}) of CPU time, {of}, start {seconds(price.start_s)} s"
    for label, declared in (("of that", True), ("would cost", False)):
        told = [effect_cost(cost, price.cpu_s) for cost in costs if cost.declared is declared and not cost.refused]
        if told:
            yield label, "; ".join(told)
    whole = "a trial of the whole run" if price.done >= 1.0 else f"a trial of {100.0 * price.done:.2g} % of the run"
    more = "" if any(not cost.refused for cost in costs) else "; --effects tries the scene without each effect"
    yield "known from", whole + more


def effect_cost(cost: EffectPrice, whole: float) -> str:
    """An effect with its cost, as "friction: +0.9 s, +12 %", of the cost of all steps as declared."""
    if cost.reason:
        return f"{cost.effect}: {cost.reason}"
    more = f", {cost.iterations:+.0f} iterations" if abs(cost.iterations) >= 0.5 else ""
    if abs(cost.cpu_s) < NOTHING * whole:
        return f"{cost.effect}: 0 s{more}"
    return f"{cost.effect}: {cost.cpu_s:+.2g} s, {100.0 * cost.cpu_s / whole:+.0f} %{more}"


def seconds(value: float) -> str:
    """A time of two figures."""
    return f"{value:.2g}" if abs(value) < 100.0 else f"{value:.0f}"


def overview(explanation: Explanation, spare: Sequence[str], command: str, price: Mapping[str, str]) -> Sheet:
    """Table of effects, what can be left out, cost and packages, on one screen.

    command  scene and settings as typed
    price    lines on what it will cost, by their labels
    """
    lines: list[tuple[str, str]] = []
    for label, text in _lines(explanation, spare):
        lines += [(label, text), *(price.items() if label == "memory" else ())]
    more = f"contactlab explain {command} --all; compare {command} --effects"
    return facts(explanation.scene.name, [*lines, ("more", more)])


def _stable(s: Overview) -> str:
    """The stable step in words, and the influence of effects; empty if there is none."""
    if s.stable_step != s.stable_step:
        return ""
    shortened = s.stable_step < SHORTENED * s.bodies_step
    effects = f" by effects or contact pressures, {number(s.bodies_step)} s without" if shortened else ""
    return f" (the stable step is {number(s.stable_step)} s{effects})"


def _lines(e: Explanation, spare: Sequence[str]) -> Iterator[tuple[str, str]]:
    s = e.scene
    size = f"{number(s.cells)} cells, {number(s.nodes)} nodes, {number(s.quadrature_points)} quadrature points"
    yield "size", size + (f", {number(s.contact_multipliers)} multipliers" if s.contact_multipliers else "")
    of = f"{number(s.step)} s{_stable(s)}"
    if s.steps_follow != "time":
        of = f"{number(s.step)}, parts of {s.steps_follow}"
    if s.integrator:
        yield "integrator", s.integrator
    yield "steps", f"about {number(s.estimated_steps)} of {of}"
    yield "history", together(s.history)
    if s.contact_forces:
        yield "forces", s.contact_forces
    if e.costs:
        yield "of a step", _costs(e)
    arrays = f"{number(e.scene.array_bytes / 2**20)} MiB in {len(e.arrays)} arrays"
    whole = f"{number(round(e.price.memory_mib))} MiB, of which " if e.price and e.price.memory_mib > 0.0 else ""
    yield "memory", whole + arrays
    yield "effects", ", ".join(f"{f.effect} ({together(f.by)})" for f in e.effects if f.called_for)
    yield "can be left out", ", ".join(spare) or "nothing: each effect is needed by another"
    yield "not declared", ", ".join(f.effect for f in e.effects if not f.called_for)
    if e.missing:
        yield "missing", "\n".join(e.missing)
    parts: dict[str, list[str]] = {}
    for used in e.parts:
        parts.setdefault(used.package, []).append(used.part)
    yield "needs", "; ".join(f"{package} ({', '.join(dict.fromkeys(own))})" for package, own in parts.items())
    outside = [module for module in e.modules if not module.package.startswith("contactlab")]
    libraries = sum(not module.plugin for module in outside)
    compiled = sum(kernel.compiled for kernel in e.kernels)
    kernels = f"{len(e.kernels)} kernels" + (f" ({compiled} compiled just now)" if compiled else "")
    yield "imports", f"{libraries} libraries besides contactlab and its plugins; {kernels}"
    given = [f"{m.package} ({m.modules})" if m.modules else m.package for m in outside if m.plugin]
    if given:
        yield "of plugins", ", ".join(given)


def together(keys: str) -> str:
    """Keys that differ in one name alone as one: bodies.{anvil,punch}.material; other words as they are."""
    names: dict[tuple[str, str], list[str]] = {}
    for word in keys.split(", "):
        key = KEY.fullmatch(word)
        around, name = ((key["table"], key["rest"] or ""), key["name"]) if key else ((word, ""), "")
        names.setdefault(around, []).append(name)
    told = []
    for (before, after), found in names.items():
        one = found[0] if len(found) == 1 else f"{{{','.join(found)}}}"
        told.append(".".join(part for part in (before, one, after) if part))
    return ", ".join(told)


def _costs(e: Explanation) -> str:
    """Shares of the wall time of a step, and a word where that is far from its CPU time."""
    from contactlab.reports.numbers import percent
    from contactlab.reports.run_details import part_label, why_apart

    wall = e.scene.wall_seconds_per_step
    rest = max(0.0, wall - sum(cost.seconds for cost in e.costs))
    told = [f"{cost.what}{part_label(cost.part)} {percent(cost.seconds / wall)} %" for cost in e.costs]
    told.append(f"rest {percent(rest / wall)} %")
    apart = why_apart(e.scene.seconds_per_step, wall)
    return f"{', '.join(told)} of {number(1e6 * wall)} µs wall time{f', {apart}' if apart else ''}"


def plain(explanation: Explanation) -> dict[str, Any]:
    """Sections of an explanation by title: the single numbers as a table first."""
    sections = {field.name: getattr(explanation, field.name) for field in dataclasses.fields(explanation)}
    price = dataclasses.asdict(explanation.price) if explanation.price is not None else {}
    return sections | {"scene": dataclasses.asdict(explanation.scene), "price": price}


def section(title: str, content: Any) -> Sheet:
    """A table of rows (records or plain values), or of names and values."""
    if isinstance(content, Mapping):
        named = ([str(name).replace("_", " "), _cell(value)] for name, value in content.items())
        return Sheet(("quantity", "value"), named, title)
    rows = [_record(row) for row in content] if isinstance(content, Sequence | set | frozenset) else [_record(content)]
    names = rows[0] if rows else ["name"]
    heads = [Column(name.replace("_", " "), keep=True) for name in names]
    return Sheet(heads, (map(_cell, row.values()) for row in rows or [{"name": "none"}]), title)


def _record(row: Any) -> dict[str, Any]:
    if dataclasses.is_dataclass(row) and not isinstance(row, type):
        return {field.name: getattr(row, field.name) for field in dataclasses.fields(row)}
    if isinstance(row, Mapping):
        return dict(row)
    if hasattr(row, "_asdict"):
        return dict(row._asdict())
    return {"name": row}


def _cell(value: Any) -> str:
    if isinstance(value, tuple | list | set | frozenset):
        return ", ".join(_cell(item) for item in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return number(value)
