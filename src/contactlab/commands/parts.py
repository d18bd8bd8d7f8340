"""`contactlab parts`: list installed parts, and describe the fields of a part."""

from __future__ import annotations

import argparse
from typing import Any

from contactlab.commands.common import ROOM_TO_SPARE, console, print_json, registry_with
from contactlab.errors import PartError, did_you_mean
from contactlab.parts.loading import Broken
from contactlab.parts.registry import Offer, Registry, usual_order
from contactlab.reports.sheet import Column, Sheet
from contactlab.scene.auto import AUTO


def parts(options: argparse.Namespace) -> int:
    """List usable parts by kind, and everything broken with its reason; or describe a part."""
    registry = registry_with(options.files)
    if options.name is not None:
        return _tell(_found(options.name, registry), registry, options.json)
    broken = [*registry.broken(), *registry.incomplete()]
    unusable = {(item.origin, item.item) for item in broken}
    usable = [
        offer for offer in registry.parts() if (offer.origin, f"{offer.part.kind} {offer.part.name}") not in unusable
    ]
    if options.json:
        print_json(_as_json(usable, broken, registry))
        return 0
    _print_parts(usable, broken, registry.burdens(), registry.commands())
    return 0


def _found(name: str, registry: Registry) -> list[Offer]:
    """The parts of this name; "kind.name" selects a kind. Raises PartError with the nearest name."""
    kind, _, bare = name.rpartition(".")
    offers = [o for o in registry.parts() if o.part.name == bare and kind in ("", o.part.kind)]
    if not offers:
        names = list(dict.fromkeys(offer.part.name for offer in registry.parts()))
        order = f'integrator = "auto" tries {", then ".join(usual_order(registry))}' if bare == AUTO else ""
        raise PartError(
            "no part of this name is installed",
            where="parts",
            got=name,
            allowed="a name listed by contactlab parts, or KIND.NAME",
            hint=order or did_you_mean(bare, names) or registry.missing_from(bare),
        )
    return offers


def _tell(offers: list[Offer], registry: Registry, as_json: bool) -> int:
    from contactlab.commands.part_page import page_of, print_page

    pages = [page_of(offer, registry) for offer in offers]
    if as_json:
        print_json({"format": 1, "parts": pages})
        return 0
    out = console()
    for page in pages:
        print_page(page, out)
    return 0


def _as_json(usable: list[Offer], broken: list[Broken], registry: Registry) -> dict[str, Any]:
    return {
        "format": 1,
        "parts": [part_json(offer) for offer in usable],
        "commands": [{"name": name, **_origin_json(origin)} for name, (_, origin) in registry.commands().items()],
        "broken": [{"item": item.item, "reason": item.reason, **_origin_json(item.origin)} for item in broken],
    }


def part_json(offer: Offer) -> dict[str, Any]:
    """A part as plain data."""
    part = offer.part
    named = {"kind": part.kind, "name": part.name, "summary": part.summary, "reference": part.reference}
    return {**named, "target": part.target, **_origin_json(offer.origin)}


def _origin_json(origin: Any) -> dict[str, str]:
    return {"plugin": origin.plugin, "distribution": origin.distribution, "version": origin.version}


def _print_parts(usable: list[Offer], broken: list[Broken], burdens: list[Broken], commands: Any) -> None:
    out = console()
    out.print(_parts_table(usable, out.width))
    if commands:
        more = ([name, str(origin)] for name, (_, origin) in commands.items())
        out.print(Sheet(("command", "from"), more, "further commands"))
    if broken:
        wrong = ([item.origin.plugin, str(item.origin), item.item, item.reason] for item in broken)
        heads = "plugin", "from", "what", Column("why it is left out", keep=True)
        out.print(Sheet(heads, wrong, "broken"))
    for item in burdens:
        out.print(f"{item.origin}: {item.reason}", markup=False, highlight=False)
    out.print("Fields, units, defaults and an example of a part: contactlab parts NAME", highlight=False)


def _parts_table(usable: list[Offer], width: int) -> Sheet:
    """Each kind is named once; a narrow table names each package in a line above its parts."""
    roomy = width >= ROOM_TO_SPARE
    names = ("kind", "name", "from", "what it is", "published in") if roomy else ("kind", "name", "what it is")
    heads = [Column(name, whole=name in ("kind", "name", "from"), keep=True) for name in names]
    rows: list[list[str]] = []
    kind = package = ""
    for offer in usable:
        part, origin = offer.part, str(offer.origin)
        new = part.kind if part.kind != kind else ""
        if roomy:
            rows.append([new, part.name, origin, part.summary, part.reference])
        else:
            if new or origin != package:
                rows.append([new, "", f"from {origin}:"])
            rows.append(["", part.name, part.summary])
        kind, package = part.kind, origin
    return Sheet(heads, rows)
