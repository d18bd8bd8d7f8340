"""Studies of cases: which cases, which contenders, at which mesh levels, and for how long."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from contactlab.cases.methods import method_name
from contactlab.errors import RequestError, did_you_mean
from contactlab.scene.fields import key
from contactlab.scene.reading import read_table
from contactlab.scene.toml_text import location, read_toml
from contactlab.studies.study import MOST_RUNS

FOLDER = Path(__file__).parent.parent / "data" / "case_studies"
TARGETS = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Errors that are asked for, as fractions."""


@dataclass(frozen=True)
class CaseChoice:
    """An entry of `cases`: a case, or a scene with a reference, and which of its errors counts."""

    use: str = key("", says="name of a case")
    scene: str = key("", says="name or file of a scene, whose pressure is compared with a reference")
    name: str = key("", says="how tables call it; not written: the name of the case or scene")
    error: str = key("", says="the measure that counts; not written: its first relative error, one in L2 before others")
    answer: float | None = key(None, says="what the measure should be; not written: as the case says")
    uncertainty: float | None = key(
        None, least=0.0, says="of the reference, as a fraction; not written: the case's own"
    )
    kind: Literal["", "exact", "two-discretisations", "other-code", "finest"] = key(
        "", says="of the reference; not written: the case's own"
    )
    why: str = key("", says="where that uncertainty comes from")
    reference: str = key("", says="of a scene: its name, or a JSON or CSV file; not written: the first that fits")
    fields: Any = key(None, says="fields of the case")
    changes: Any = key(None, says="scene keys and values")
    levels: tuple[int, ...] = key((), least=1, says="mesh levels; not written: those of the study")
    targets: tuple[float, ...] = key((), above=0.0, says="errors asked for, as fractions; not written: the study's")

    def __post_init__(self) -> None:
        if bool(self.use) == bool(self.scene):
            raise ValueError(f"use: got {self.use or 'nothing'}, allowed: either a case (use) or a scene (scene)")

    @property
    def label(self) -> str:
        """Name in tables."""
        return self.name or self.use or Path(self.scene).stem


@dataclass(frozen=True)
class Contender:
    """An entry of `contenders`: an algorithm with an element, an integrator and an enforcement."""

    way: str = key(says="what tables call integrator and enforcement together: statics, explicit ...")
    element: str = key(says="of the bodies")
    integrator: Any = key(says="integrator, or a table with its fields")
    algorithm: Any = key("*", says='contact algorithm, or "*" for each that is installed')
    enforcement: Any = key(None, says="of the contact; not written: the integrator's own")
    changes: Any = key(None, says="further scene keys and values")
    levels: tuple[int, ...] = key((), least=1, says="mesh levels; not written: those of the case or of the study")
    slaves: tuple[Literal["declared", "exchanged"], ...] = key(
        (), says="which side carries the multipliers; not written: either in turn"
    )

    @property
    def label(self) -> str:
        """Name in tables."""
        return " ".join(filter(None, [method_name(self.algorithm), self.element, self.way]))


@dataclass(frozen=True)
class Quick:
    """`[quick]`: what `--quick` leaves of a study."""

    cases: tuple[str, ...] = key((), says="of the study's cases, by label; not written: all")
    ways: tuple[str, ...] = key((), says="of the study's contenders, by way; not written: all")
    elements: tuple[str, ...] = key((), says="of the study's contenders, by element; not written: all")
    levels: tuple[int, ...] = key((1, 2), least=1, says="mesh levels")
    limit: float = key(10.0, above=0.0, says="CPU time of one run [s]")
    budget: float = key(150.0, above=0.0, says="CPU time of all runs [s]; what is left then is not run")


@dataclass(frozen=True)
class CaseStudy:
    """A study of cases.

    quick  what `--quick` leaves of it
    """

    cases: tuple[CaseChoice, ...] = key(says="cases and scenes")
    contenders: tuple[Contender, ...] = key(says="what is put to them")
    format: Literal[1] = key(1, says="version of the study format")
    name: str = key("", says="heading of the page")
    levels: tuple[int, ...] = key((1, 2, 4), least=1, says="mesh levels")
    order: Literal["levels", "contenders", "costs"] = key(
        "levels",
        says="levels: coarse ones of all contenders first; contenders: one with all of its levels after another; "
        "costs: level 1 of all contenders, then whatever is expected to cost least",
    )
    join: bool = key(True, says="whether cases of other packages than the study's take part")
    limit: float = key(30.0, above=0.0, says="CPU time of one run [s]; what needs more is not run, or stopped")
    budget: float | None = key(None, above=0.0, says="CPU time of all runs [s]; what is left then is not run")
    repeat: int = key(
        3, least=1, most=MOST_RUNS, says="runs of each point that takes less than `short`; costs are medians"
    )
    short: float = key(1.0, above=0.0, says="CPU time [s] up to which a run is repeated")
    targets: tuple[float, ...] = key(TARGETS, above=0.0, says="errors that are asked for, as fractions")
    quick: Quick = field(default=Quick(), metadata={"says": "what --quick leaves of it"})
    path: Path | None = field(default=None, metadata={"hidden": True})

    def quickened(self) -> CaseStudy:
        """The study that `--quick` runs."""
        q = self.quick
        cases = tuple(case for case in self.cases if not q.cases or case.label in q.cases)
        contenders = tuple(
            c for c in self.contenders if c.way in (q.ways or (c.way,)) and c.element in (q.elements or (c.element,))
        )
        cases = tuple(replace(case, levels=()) for case in cases)
        return replace(self, cases=cases, contenders=contenders, levels=q.levels, limit=q.limit, budget=q.budget)


def bundled_case_studies() -> dict[str, Path]:
    """Paths of the bundled studies of cases by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def find_case_study(request: str) -> CaseStudy | None:
    """The study of cases of a name or in a file; None where the request is something else. Raises RequestError."""
    path = bundled_case_studies().get(request, Path(request))
    try:
        there = path.is_file()
    except OSError:  # no name that a file could have
        there = False
    if not there:
        return None
    data, lines = read_toml(path, str(path))
    if "cases" not in data and "contenders" not in data:
        return None
    data.setdefault("name", path.stem)
    study = read_table(CaseStudy, data, location(str(path), lines), path=path)
    elements = list(dict.fromkeys(c.element for c in study.contenders))
    ways = list(dict.fromkeys(c.way for c in study.contenders))
    for wanted, known, what in (
        (study.quick.cases, [case.label for case in study.cases], "cases"),
        (study.quick.elements, elements, "elements"),
        (study.quick.ways, ways, "ways"),
    ):
        for name in wanted:
            if name not in known:
                raise RequestError(
                    f"quick.{what} names what the study has not", where=f"{study.path}, quick.{what}", got=name,
                    allowed=", ".join(known), hint=did_you_mean(name, known),
                )  # fmt: skip
    seen: set[str] = set()
    for choice in study.cases:
        if choice.label in seen:
            raise RequestError(
                "two cases have the same name", where=f"{study.path}, cases", got=choice.label, hint="add a key name"
            )
        seen.add(choice.label)
    return study
