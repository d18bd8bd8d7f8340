"""Plants defects into shipped parts and asks `contactlab check` about each: `make mutants`.

    python tests/abuse/mutants.py                  # all of them; a line for each, the share caught at the end
    python tests/abuse/mutants.py contact 17 lost  # of a kind, by number, or with a word in what they say
    python tests/abuse/mutants.py --page           # the same, and the section of docs/check.md is written anew

A mutant is a piece of a source of a shipped part, or of what the core does for implicit schemes, that is exchanged for
another. Only the modules that see it are
copied, under names of their own; everything else is as installed.
"""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

from mutations import MUTATIONS, Mutation

from contactlab.parts.registry import Registry, default_registry
from contactlab.testing.check_part import PartReport, check_part
from contactlab.testing.subject import Subject

PAGE = Path(__file__).parents[2] / "docs" / "check.md"
MARKS = ("<!-- mutants: written by make mutants -->\n", "<!-- end of mutants -->\n")


CORE = "contactlab.implicit."
BOUND = """
from dataclasses import dataclass
from {module} import {name} as Shipped
from contactlab.implicit.motion import SolvedMotion


@dataclass(frozen=True)
class {name}(Shipped):
    __doc__ = Shipped.__doc__

    def bind(self, equations, state):
        return SolvedMotion(self, equations, state).advance
"""


class Verdict(NamedTuple):
    """A mutant, the first check that failed on it (empty where none did) and its reason."""

    number: int
    mutation: Mutation
    check: str
    reason: str


def planted(mutation: Mutation, number: int, folder: Path) -> Subject:
    """The wrong part as something to check. Its modules are written to `folder`, which is on the path."""
    shipped = default_registry().part_class(mutation.kind, mutation.part)
    mutated, target = module_of(mutation), shipped.__module__
    sources = _sources(mutated.rpartition(".")[0])
    if mutated.startswith(CORE):  # the part is bound by a copy of the core's own `SolvedMotion`
        target = f"{CORE}bound"
        sources[target] = BOUND.format(module=shipped.__module__, name=shipped.__name__)
    changed = sources[mutated].replace(mutation.old, mutation.new, 1)
    assert changed != sources[mutated], f"mutant {number}: {mutation.old!r} does not stand in {mutated}"
    copied = _seeing(mutated, sources)
    assert target in copied, f"mutant {number}: {target} does not see {mutated}"
    names = {name: f"mutant_{number}_{name.rpartition('.')[2]}" for name in copied}
    for name in copied:
        text = changed if name == mutated else sources[name]
        for old, new in names.items():
            text = re.sub(rf"\b{re.escape(old)}\b", new, text)
        (folder / f"{names[name]}.py").write_text(text, encoding="utf-8")
    hook = folder / f"mutant_{number}_hooks.py"
    part = f'Part("{mutation.kind}", "mutant-{number}", "{names[target]}:{shipped.__name__}", "a wrong part")'
    hook.write_text(
        f"from contactlab.api.plugin import Part, hookimpl\n\n@hookimpl\ndef contactlab_parts():\n    return [{part}]\n"
    )
    importlib.invalidate_caches()
    return Subject(Registry(files=[hook]), mutation.kind, f"mutant-{number}", mutation.fields)


def module_of(mutation: Mutation) -> str:
    """Dotted name of the module that is changed."""
    target = default_registry().part_class(mutation.kind, mutation.part).__module__
    if "." in mutation.file:
        return mutation.file
    return f"{target.rpartition('.')[0]}.{mutation.file}" if mutation.file else target


def _sources(package: str) -> dict[str, str]:
    """Texts of the modules of a package by dotted name, each import with the whole name of its module."""
    root = Path(str(importlib.import_module(package).__file__)).parent
    texts = {f"{package}.{p.stem}": p.read_text(encoding="utf-8") for p in root.glob("*.py") if p.stem != "__init__"}
    return {name: re.sub(rf"^from {package} import (\w+)$", rf"import {package}.\1 as \1", text, flags=re.M)
            for name, text in texts.items()}  # fmt: skip


def _seeing(mutated: str, sources: dict[str, str]) -> set[str]:
    """The mutated module and all that import it, one through another; entry modules never count."""
    seeing = {mutated}
    while True:
        more = {
            name for name, text in sources.items()
            if not name.endswith(".plugin") and any(re.search(rf"\b{re.escape(other)}\b", text) for other in seeing)
        } - seeing  # fmt: skip
        if not more:
            return seeing
        seeing |= more


def verdict(mutation: Mutation, number: int, folder: Path) -> Verdict:
    """Whether the check finds the defect, and how."""
    report: PartReport = check_part(planted(mutation, number, folder), until_failure=True)
    failed = [outcome for outcome in report.outcomes if outcome.status == "failed"]
    return Verdict(number, mutation, failed[0].check, failed[0].reason) if failed else Verdict(number, mutation, "", "")


def wanted(words: list[str]) -> Iterator[tuple[int, Mutation]]:
    """Those of the words: a kind, a number, or part of what is said."""
    for number, mutation in enumerate(MUTATIONS):
        texts = (mutation.kind, str(number), mutation.part)
        if not words or any(word in texts or word in mutation.says for word in words):
            yield number, mutation


def section(verdicts: list[Verdict]) -> str:
    """What stands in docs/check.md."""
    kinds = list(dict.fromkeys(v.mutation.kind for v in verdicts))
    caught = [v for v in verdicts if v.check]
    share = 100.0 * len(caught) / len(verdicts)
    lines = [f"Of {len(verdicts)} mutants `contactlab check` fails {len(caught)}: {share:.0f} %.", ""]
    lines += ["| kind | mutants | caught |", "|---|---|---|"]
    for kind in kinds:
        own = [v for v in verdicts if v.mutation.kind == kind]
        lines.append(f"| {kind} | {len(own)} | {sum(bool(v.check) for v in own)} |")
    missed = [v for v in verdicts if not v.check]
    lines += ["", "Not caught:" if missed else "None is left.", ""]
    lines += [f"- {v.mutation.kind} `{v.mutation.part}`, {v.mutation.says}" for v in missed]
    return "\n".join(lines).rstrip() + "\n"


def main(words: list[str]) -> int:
    """Check the mutants that are meant; exit status 1 where fewer than 95 % are caught."""
    write, words = "--page" in words, [word for word in words if word != "--page"]
    verdicts: list[Verdict] = []
    with TemporaryDirectory() as place:
        sys.path.insert(0, place)
        for number, mutation in wanted(words):
            began = perf_counter()
            found = verdict(mutation, number, Path(place))
            verdicts.append(found)
            told = f"{found.check}: {found.reason}"[:150] if found.check else "NOT CAUGHT"
            print(f"{number:3d} {mutation.kind} {mutation.part}, {mutation.says}: {told} "
                  f"({perf_counter() - began:.1f} s)", flush=True)  # fmt: skip
    print("\n" + section(verdicts))
    if write:
        text = PAGE.read_text(encoding="utf-8")
        before, _, rest = text.partition(MARKS[0])
        PAGE.write_text(
            before + MARKS[0] + section(verdicts) + MARKS[1] + rest.partition(MARKS[1])[2], encoding="utf-8"
        )
    return 0 if sum(bool(v.check) for v in verdicts) >= 0.95 * len(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
