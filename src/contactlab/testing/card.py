"""A card for authors to show: the checks of a part with date, versions and results."""

from __future__ import annotations

import json
import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from contactlab.jobs.keys import sources
from contactlab.parts.provenance import LIBRARIES
from contactlab.testing.check_part import PartReport
from contactlab.testing.run import Outcome

OUTCOMES = {"not applicable": "not-applicable"}
"""Outcomes that have other names in JSON."""


def as_data(reports: Sequence[PartReport]) -> dict[str, Any]:
    """The results as plain data."""
    return {"format": 1, "parts": [_part(report) for report in reports]}


def _part(report: PartReport) -> dict[str, Any]:
    return {
        "kind": report.kind,
        "name": report.name,
        "passed": report.count("passed"),
        "failed": report.count("failed"),
        "from": report.origin,
        "declares": report.tags,
        "checks": [_check(outcome) for outcome in report.outcomes],
        "cost": [{"name": c.name, "us": round(c.microseconds, 3), "of": c.of} for c in report.costs],
        "cpu_s": round(report.cpu_s, 2),
    }


def _check(outcome: Outcome) -> dict[str, str]:
    status = OUTCOMES.get(outcome.status, outcome.status)
    return {"name": outcome.check, "outcome": status, "reason": outcome.reason, "says": outcome.says}


def write_cards(reports: Sequence[PartReport], folder: Path) -> None:
    """Write card.json and card.md to a folder, created if needed."""
    found = {"python": platform.python_version()} | {name: version(name) for name in LIBRARIES}
    for origin in sorted({report.origin for report in reports}):
        name, _, number = origin.rpartition(" ")
        if name and not origin.endswith(".py"):  # a file is not a distribution: its hash identifies it
            found[name] = number
    data = {
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "versions": found,
        "sources": {_package(report): sources({_package(report)})[-1] for report in reports},
        **as_data(reports),
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "card.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    (folder / "card.md").write_text(_page(data), encoding="utf-8")


def _package(report: PartReport) -> str:
    return report.target.partition(":")[0].partition(".")[0]


def _page(data: dict[str, Any]) -> str:
    versions = ", ".join(f"{name} {number}" for name, number in data["versions"].items())
    lines = ["# Checked by contactlab", "", f"{data['date']}, {versions}.", ""]
    lines += [f"- sources of `{package}`: `{digest}`" for package, digest in data["sources"].items()]
    for part in data["parts"]:
        verdict = "nothing failed" if not part["failed"] else f"{part['failed']} failed"
        declared = ", ".join(f"{name} = {value}" for name, value in part["declares"].items())
        lines += ["", f"## {part['kind']} `{part['name']}`: {part['passed']} passed, {verdict}", ""]
        lines += [f"Declares {declared}.", ""] if declared else []
        lines += ["| check | outcome | reason |", "|---|---|---|"]
        for check in part["checks"]:
            reason = check["reason"].replace("|", "\\|").replace("\n", " ")
            lines.append(f"| {check['name'].replace('_', ' ')} | {check['outcome']} | {reason} |")
        if part["cost"]:
            lines += ["", f"CPU time of {part['cost'][0]['of']}: "
                      + ", ".join(f"{cost['name']} {cost['us']:.4g} us" for cost in part["cost"]) + "."]  # fmt: skip
    return "\n".join(lines) + "\n"
