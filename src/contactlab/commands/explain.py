"""`contactlab explain`: what a scene calls for and what it does not."""

from __future__ import annotations

import argparse
import dataclasses
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from contactlab.commands.common import add_row, console, number, parse_settings, print_json, registry_with, table
from contactlab.scene.scene import load_scene

if TYPE_CHECKING:
    from contactlab.explain.explain import Explanation, Overview
    from contactlab.prices.foreseen import Bill, EffectPrice
    from contactlab.scene.scene import Scene

NOTHING = 0.005  # of the cost of a run: a price that is told as 0
SHORTENED = 0.9  # of the stable step of the bodies: usual steps are as long, and effects make them shorter
LITTLE = 0.05  # s at the start: about what two starts differ by
KEY = re.compile(r"(?P<table>[a-z]+)\.(?P<name>[\w-]+)(\.(?P<rest>[\w.]+))?")


def explain(options: argparse.Namespace) -> int:
    """Print the explanation of the scene; but for the first steps, which are thrown away, nothing is run."""
    from contactlab.explain.explain import explain as explanation_of
    from contactlab.explain.trial_run import run_trial
    from contactlab.studies.removable import variants

    registry = registry_with(options.files)
    scene = load_scene(options.scene, registry).with_(parse_settings(options.settings))
    explanation = explanation_of(scene, registry, run_trial(scene))
    spare = [variant.effect for variant in variants(scene) if variant.declared]
    bill = foreseen(scene)
    shown = console()
    if options.json:
        priced = {"unknown": bill} if isinstance(bill, str) else dataclasses.asdict(bill)
        print_json({"format": 1, **plain(explanation), "can_be_left_out": spare, "price": priced})
    elif options.everything:
        for title, content in plain(explanation).items():
            shown.print(section(title.replace("_", " "), content))
        shown.print(
            section(
                "price", {"unknown": bill} if isinstance(bill, str) else {**bill.summary, "prices_from": bill.basis}
            )
        )
        if not isinstance(bill, str):
            shown.print(section("price of effects", bill.effects))
    else:
        command = shlex.join([options.scene, *(word for text in options.settings for word in ("--set", text))])
        shown.print(overview(explanation, spare, command, dict(price_lines(bill))))
    return 0


def foreseen(scene: Scene) -> Bill | str:
    """What the scene and its effects will cost, or why that is not known."""
    from contactlab.prices.foreseen import bill_of
    from contactlab.prices.kept_trials import NO_TRIALS, BrokenTrialsError, load_trials
    from contactlab.prices.price_list import NoPricesError, load_prices

    trials, broken = NO_TRIALS, ""
    try:
        trials = load_trials()
    except BrokenTrialsError as error:
        broken = str(error)
    try:
        bill = bill_of(scene, load_prices(), trials)
    except NoPricesError as error:
        return str(error)
    return dataclasses.replace(bill, basis=f"{bill.basis}; {broken}") if broken else bill


def price_lines(bill: Bill | str) -> Iterator[tuple[str, str]]:
    """What the whole run will cost, what its effects do in it, and what others would."""
    if isinstance(bill, str):
        yield "price", f"not known: {bill}"
        return
    whole = bill.whole
    yield (
        "price",
        (
            f"{seconds(bill.start_s + whole.cpu_s)} s of CPU time ({seconds(bill.start_s + whole.least_s)} to "
            f"{seconds(bill.start_s + whole.most_s)}), {seconds(whole.cpu_s)} s of them for its steps; "
            f"{number(round(bill.process_mib + whole.arrays_mib))} MiB"
            + (f"; without {', '.join(whole.unknown)}, of which no price is known" if whole.unknown else "")
        ),
    )
    for label, declared in (("of that", True), ("would cost", False)):
        told = [effect_price(e, whole.cpu_s) for e in bill.effects if e.declared is declared and not e.refused]
        if told:
            yield label, "; ".join(told)
    yield "prices from", bill.basis


def effect_price(effect: EffectPrice, whole: float) -> str:
    """An effect with its price, as "friction: +0.9 s, +12 %", the share that of the steps of the run as declared."""
    if effect.failed:
        return f"{effect.effect}: none, its trial failed"
    if effect.reason:
        return f"{effect.effect}: {effect.reason}"
    start = f", {effect.start_s:+.2g} s at the start" if abs(effect.start_s) > LITTLE else ""
    if abs(effect.cpu_s) < NOTHING * whole:
        return f"{effect.effect}: 0 s{start}"
    return f"{effect.effect}: {effect.cpu_s:+.2g} s, {100.0 * effect.cpu_s / whole:+.0f} %{start}"


def seconds(value: float) -> str:
    """A time of two figures."""
    return f"{value:.2g}" if abs(value) < 100.0 else f"{value:.0f}"


def overview(explanation: Explanation, spare: Sequence[str], command: str, price: Mapping[str, str]) -> Any:
    """What the scene pays for, could spare and needs, on one screen.

    command  scene and settings as typed
    price    lines on what it will cost, by their labels
    """
    from rich import box
    from rich.table import Table

    shown = Table(
        box=box.SIMPLE_HEAD, show_header=False, pad_edge=False, title=explanation.scene.name, title_justify="left",
        title_style="bold",
    )  # fmt: skip
    shown.add_column(style="bold", no_wrap=True)
    shown.add_column(overflow="fold")
    for label, text in _lines(explanation, spare):
        add_row(shown, label, text)
        if label == "memory":
            for name, told in price.items():
                add_row(shown, name, told)
    add_row(shown, "cost of each", f"contactlab compare {command} --effects")
    add_row(shown, "every detail", f"contactlab explain {command} --all")
    return shown


def _stable(s: Overview) -> str:
    """The stable step in words, and what effects have to do with it; nothing where there is none."""
    if s.stable_step != s.stable_step:
        return ""
    shortened = s.stable_step < SHORTENED * s.bodies_step
    effects = f" by the effects, {number(s.bodies_step)} s without" if shortened else ""
    return f" (the stable one is {number(s.stable_step)} s{effects})"


def _lines(e: Explanation, spare: Sequence[str]) -> Iterator[tuple[str, str]]:
    s = e.scene
    size = f"{number(s.cells)} cells, {number(s.nodes)} nodes, {number(s.quadrature_points)} quadrature points"
    yield "size", size + (f", {number(s.contact_multipliers)} multipliers" if s.contact_multipliers else "")
    of = f"{number(s.step)} s{_stable(s)}"
    if s.steps_follow != "time":
        of = f"{number(s.step)}, parts of {s.steps_follow}"
    yield "steps", f"about {number(s.estimated_steps)} of {of}"
    yield "history", together(s.history)
    if s.contact_forces:
        yield "forces", s.contact_forces
    yield (
        "time",
        (
            f"about {number(s.estimated_seconds)} s: {number(s.seconds_to_first_step)} s until the first step is done, "
            f"{number(1e6 * s.seconds_per_step)} µs for each further one"
        ),
    )
    if e.costs:
        yield "of a step", _costs(e)
    yield "memory", f"{number(e.scene.array_bytes / 2**20)} MiB in {len(e.arrays)} arrays"
    yield "pays for", ", ".join(f"{f.effect} ({together(f.by)})" for f in e.effects if f.called_for)
    yield "could spare", ", ".join(spare) or "nothing: each effect is needed by another"
    yield "not declared", ", ".join(f.effect for f in e.effects if not f.called_for)
    yield "needs", "; ".join(_packages(e))
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


def _packages(e: Explanation) -> Iterator[str]:
    """Each package with the parts that it gives."""
    given: dict[str, list[str]] = {}
    for used in e.parts:
        given.setdefault(used.package, []).append(used.part)
    yield from (f"{package} ({', '.join(dict.fromkeys(parts))})" for package, parts in given.items())


def plain(explanation: Explanation) -> dict[str, Any]:
    """Sections of an explanation by title: the single numbers as a table first."""
    sections = {field.name: getattr(explanation, field.name) for field in dataclasses.fields(explanation)}
    return sections | {"scene": dataclasses.asdict(explanation.scene)}


def section(title: str, content: Any) -> Any:
    """A table of rows (records or plain values), or of names and values."""
    if isinstance(content, Mapping):
        shown = table("quantity", "value", title=title)
        for name, value in content.items():
            add_row(shown, str(name).replace("_", " "), _cell(value))
        return shown
    rows = [_record(row) for row in content] if isinstance(content, Sequence | set | frozenset) else [_record(content)]
    names = rows[0] if rows else ["name"]
    shown = table(*(name.replace("_", " ") for name in names), title=title)
    for row in rows or [{"name": "none"}]:
        add_row(shown, *(_cell(value) for value in row.values()))
    return shown


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
