"""Puts every registered part to the whole of `contactlab check`: `make check-parts`.

    python tests/abuse/check_parts.py                 # all of them; a line for each, what they cost at the end
    python tests/abuse/check_parts.py contact mesh    # of some kinds, or parts by name
    python tests/abuse/check_parts.py --page          # all, and the table in docs/check.md is written anew

Times are CPU seconds of this process, kernels loaded and where there are none compiled.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from contactlab.parts.registry import default_registry
from contactlab.testing.check_part import PartReport, check_part
from contactlab.testing.subject import Subject

PAGE = Path(__file__).parents[2] / "docs" / "check.md"
MARKS = ("<!-- parts: written by make check-parts -->\n", "<!-- end of parts -->\n")


def wanted(words: list[str]) -> Iterator[Subject]:
    """Parts of the kinds or with the names that are meant; all without any."""
    registry = default_registry()
    for kind, name in ((offer.part.kind, offer.part.name) for offer in registry.parts()):
        if not words or kind in words or name in words:
            yield Subject(registry, kind, name)


def section(reports: list[PartReport]) -> str:
    """What stands in docs/check.md."""
    right = sum(report.right for report in reports)
    alone = [f"{report.kind} `{report.name}`" for report in reports if not report.right and not report.count("failed")]
    without = f" Without a file of its own nothing can be checked of {', '.join(alone)}." if alone else ""
    lines = [f"Of {len(reports)} shipped parts {right} pass.{without}", ""]
    lines += ["| kind | parts | checks passed | expected | failed | dearest part, CPU s |", "|---|---|---|---|---|---|"]
    for kind in dict.fromkeys(report.kind for report in reports):
        own = [report for report in reports if report.kind == kind]
        counts = [sum(report.count(status) for report in own) for status in ("passed", "expected", "failed")]
        dearest = max(own, key=lambda report: report.cpu_s)
        lines.append(
            f"| {kind} | {len(own)} | {' | '.join(map(str, counts))} | {dearest.cpu_s:.1f} (`{dearest.name}`) |"
        )
    return "\n".join(lines) + "\n"


def main(words: list[str]) -> int:
    """Check the parts that are meant; exit status 1 where any fails."""
    write, words = "--page" in words, [word for word in words if word != "--page"]
    reports = []
    for subject in wanted(words):
        report = check_part(subject)
        reports.append(report)
        failed = [f"{o.check}: {o.reason}" for o in report.outcomes if o.status == "failed"]
        print(f"{report.kind} {report.name}: {report.count('passed')} passed, {report.count('expected')} expected, "
              f"{len(failed)} failed ({report.cpu_s:.1f} CPU s) {'; '.join(failed)[:300]}", flush=True)  # fmt: skip
    print("\n" + section(reports))
    if write:
        text = PAGE.read_text(encoding="utf-8")
        before, _, rest = text.partition(MARKS[0])
        PAGE.write_text(before + MARKS[0] + section(reports) + MARKS[1] + rest.partition(MARKS[1])[2], encoding="utf-8")
    return 0 if all(report.right for report in reports) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
