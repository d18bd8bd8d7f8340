"""What each contact method costs and how accurate it is: the numbers of docs/methods.md.

    python benchmarks/studies/methods.py            # measures all and keeps methods.csv, three turns, some minutes
    python benchmarks/studies/methods.py mortar-p1  # errors of some methods anew
    python benchmarks/studies/methods.py nitsche --costs  # and their costs, by turns with mortar-p0
    contactlab compare benchmarks/studies/equal_error.toml --jobs 1 --out DIR   # costs at equal errors
    python benchmarks/studies/methods.py --equal DIR      # keeps those of its cases in equal_error.csv

Pressures of disc-on-block in statics against the reference, at three levels with either side as slave, and what the
sides' exchange changes; CPU time of a Newton iteration and of an explicit step, by turns of all methods. The page also
takes rows of the quick matrix: the patch test, Hertz, rings, energy, verdicts. `make pages` fills it in.
"""

from __future__ import annotations

import argparse
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from statistics import median
from typing import Any, Final

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402
from filled import filled  # noqa: E402

from contactlab.jobs.rows import Row, read_csv, write_csv  # noqa: E402
from contactlab.reports.sheet import Sheet  # noqa: E402

KEPT, PAGE = Path(__file__).with_name("methods.csv"), Path(__file__).parents[2] / "docs" / "methods.md"
EQUAL = KEPT.with_name("equal_error.csv")
AT_ERRORS: Final = ("case", "contender", "target", "kind", "cost", "level", "coarsest", "why")
COLUMNS: Final = ("method", "slave", "level", "quantity", "value")
LEVELS: Final = (1, 2, 4)
FINEST: Final = max(LEVELS)
DEPTH, STEPS, EXPLICIT_END = 0.1581, 5, 4e-6
BASE: Final = "mortar-p0"
PLAIN: Final = ("node-on-segment", "gauss-point", "mortar-p0", "mortar-p1", "mortar-dual")
CONES: Final = {
    f"{name}, strong cone": {"algorithm": {"use": name, "cone": "strong"}} for name in ("mortar-p0", "mortar-p1")
}
SMOOTH: Final = {f"{name}, smooth": {"algorithm": name, "smooth": True} for name in PLAIN if name.startswith("mortar")}
STATICS: Final = {
    ", ".join(["nitsche", *(f"{name} = {value}" for name, value in numbers.items())]): {
        "algorithm": "mortar-p1", "enforcement": {"use": "nitsche", **numbers},
    }
    for numbers in ({}, {"theta": 1}, {"theta": -1}, {"theta": -1, "gamma": 1.0}, {"theta": -1, "gamma": 100.0})
} | {
    "midplane": {"algorithm": "midplane"},
    **{f"midplane, stiffness = {k}": {"algorithm": {"use": "midplane", "stiffness": k}} for k in (3.0, 300.0)},
    **{
        "barrier" + (f", dhat = {dhat}" if dhat != 0.05 else ""): {"algorithm": {"use": "barrier", "dhat": dhat}}
        for dhat in (0.05, 0.005, 0.2)
    },
    **{
        "gauss-point, penalty" + (f", factor = {factor}" if factor != 100.0 else ""): {
            "algorithm": "gauss-point", "enforcement": {"use": "penalty", "factor": factor},
        }
        for factor in (100.0, 10.0, 1000.0)
    },
}  # fmt: skip
LAWS: Final = {
    "gauss-point, passes = 2" + (f", factor = {factor}" if factor != 10.0 else ""): {
        "algorithm": {"use": "gauss-point", "passes": 2},
        "enforcement": {"use": "linear-pressure", "factor": factor},
    }
    for factor in (10.0, 1.0, 100.0)
} | {
    "linear-pressure" + (f", factor = {factor}" if factor != 10.0 else ""): {
        "algorithm": "mortar-p1", "enforcement": {"use": "linear-pressure", "factor": factor},
    }
    for factor in (10.0, 1.0, 100.0)
} | {
    "exponential-pressure": {
        "algorithm": "mortar-p1", "enforcement": {"use": "exponential-pressure", "clearance": 0.005},
    },
}  # fmt: skip
METHODS: Final[Mapping[str, Mapping[str, Any]]] = {
    **{name: {"algorithm": name} for name in PLAIN}, **CONES, **SMOOTH, **STATICS, **LAWS,
}  # fmt: skip
"""Keys of the contact by the name of a method."""
SLAVES: Final = {"disc": False, "block": True}


COSTS: Final = ("iteration", "iteration, contact per node", "step", "step, contact per node")


# --- measuring --------------------------------------------------------------------------------------------------------


def scene(method: str, slave: str, level: int, changes: Mapping[str, Any]) -> Any:
    """Disc-on-block with a method."""
    import contactlab

    keys = {f"contacts.0.{name}": value for name, value in METHODS[method].items()}
    keys |= {"level": level, "contacts.0.swap": SLAVES[slave], "record.recorders": []}
    return contactlab.load_scene("disc-on-block").with_({**keys, **changes})


def statics(method: str, slave: str, level: int) -> Any:
    """A run to the full depth."""
    import contactlab

    changes = {"integrator": {"use": "newton", "steps": STEPS}, "supports.1.uy.to": -DEPTH, "record.frames": 1}
    return contactlab.simulate(scene(method, slave, level, changes))


def explicit(method: str, slave: str, level: int) -> Any:
    """The first steps in time."""
    import contactlab

    return contactlab.simulate(scene(method, slave, level, {"time.end": EXPLICIT_END, "record.frames": 1}))


def profile(results: Any) -> Any:
    """The pressure at the slave's nodes over x."""
    from contactlab.studies.profile import Profile

    curve = results.contact["contacts.0"].last
    return Profile.of_nodes(np.asarray(curve.x, float), np.nan_to_num(np.asarray(curve.pressure, float)))


def accuracies(method: str, level: int) -> list[Row]:
    """Errors of the pressure with either slave, their exchange, and the lowest pressure over the largest one."""
    from contactlab.studies.measures import mutual_difference, pressure_error
    from contactlab.studies.reference import load_reference

    reference, found, rows = load_reference("disc-on-block-deep"), {}, []
    for slave in SLAVES:
        results = statics(method, slave, level)
        if results.status != "finished":
            rows.append(_row(method, slave, level, "failed", results.status))
            continue
        found[slave] = here = profile(results)
        rows += [
            _row(method, slave, level, "error", pressure_error(here, reference.profile, reference.window)),
            _row(method, slave, level, "lowest", float(here.value.min() / here.value.max())),
            _row(method, slave, level, "iterations", results.summary["iterations"]),
        ]
    if len(found) == len(SLAVES):
        rows.append(_row(method, "", level, "swap", mutual_difference(found["disc"], found["block"])))
    return rows


def costs(turns: int, methods: Iterable[str]) -> list[Row]:
    """CPU time of an iteration at the finest level and of an explicit step at the coarsest one, medians of turns.

    And the contact's share of it per node of the slave. Methods of statics have no explicit step.
    """
    spent: dict[tuple[str, str, str], list[float]] = {}
    kinds: Mapping[str, tuple[Callable[..., Any], int]] = {"iteration": (statics, FINEST), "step": (explicit, 1)}
    for turn in range(turns + 1):  # the first one compiles
        for method in methods:
            for kind, (run, level) in kinds.items():
                if kind == "step" and method in STATICS:
                    continue
                results = run(method, "disc", level if turn else 1)
                cost = results.summary["cost"]
                each = cost["run_cpu_s"] / results.summary["iterations" if kind == "iteration" else "steps"]
                share = cost["phases"]["contact"] / sum(cost["phases"].values())
                nodes = len(results.contact["contacts.0"].last.x)
                if turn:
                    spent.setdefault((method, kind, str(level)), []).append(each)
                    spent.setdefault((method, f"{kind}, contact per node", str(level)), []).append(share * each / nodes)
    return [_row(method, "disc", int(level), kind, median(times)) for (method, kind, level), times in spent.items()]


def scaled_costs(turns: int, methods: Iterable[str], kept: list[Row]) -> list[Row]:
    """Costs of some methods, by turns with mortar-p0, times what it costs in `kept` over what it costs now."""
    found = costs(turns, dict.fromkeys((BASE, *methods)))
    now, before = _Values(found), _Values(kept)
    for row in found:
        place = "disc", int(row["level"]), row["quantity"]
        row["value"] = f"{float(row['value']) * before(BASE, *place) / now(BASE, *place):.4g}"
    return [row for row in found if row["method"] != BASE]


def keep_equal(folder: Path) -> None:
    """Keep costs at equal errors from a folder of `contactlab compare`; cases that are not there stay as they are."""
    found = [{name: row[name] for name in AT_ERRORS} for row in read_csv(folder / "costs.csv")]
    there = {row["case"] for row in found}
    write_csv(EQUAL, AT_ERRORS, [*(row for row in read_csv(EQUAL) if row["case"] not in there), *found])


def _row(method: str, slave: str, level: int, quantity: str, value: Any) -> Row:
    said = f"{value:.4g}" if isinstance(value, float) else str(value)
    return dict(zip(COLUMNS, (method, slave, str(level), quantity, said), strict=True))


# --- the page ---------------------------------------------------------------------------------------------------------

CASES: Final = {
    "patch": "stress", "hertz": "L2 of the pressure", "two-rings": "order of the carried pressure",
    "stuck-rings": "order of the carried shear, inside", "ironing": "iterations",
}  # fmt: skip
PENETRATION, SAW = "largest penetration of either side in segments", "saw-tooth of the pressure"


def stored() -> list[Row]:
    """The rows that are kept."""
    return read_csv(KEPT)


def page(rows: list[Row], cases: list[Row]) -> str:
    """docs/methods.md with its numbers put in, from those of this script and of the quick matrix."""
    tables = {
        "pressure": _pressures(rows), "cone": _cones(rows), "cost": _costs(rows), "cases": _cases(cases),
        "equal": _equal(read_csv(EQUAL)),
    }  # fmt: skip
    return filled(PAGE, **{name: table.markdown() for name, table in tables.items()})


class _Values:
    """Kept values by method, slave, level and quantity; nan where a run failed."""

    def __init__(self, rows: list[Row]) -> None:
        self._found = {tuple(row[name] for name in COLUMNS[:-1]): row["value"] for row in rows}

    def __call__(self, method: str, slave: str, level: int, quantity: str) -> float:
        return float(self._found.get((method, slave, str(level), quantity), "nan"))


def _percent(value: float) -> str:
    return "failed" if np.isnan(value) else f"{100.0 * value:.2g}"


def _pressures(rows: list[Row]) -> Sheet:
    """Errors of the pressure by level and slave, their order, and what exchanging the sides changes."""
    value, lines = _Values(rows), []
    for method in METHODS:
        if method in CONES:
            continue
        line = [_named(method)]
        for slave in SLAVES:
            errors = [value(method, slave, level, "error") for level in LEVELS]
            order = np.log(errors[0] / errors[-1]) / np.log(LEVELS[-1] / LEVELS[0])
            line += [", ".join(map(_percent, errors)), "" if np.isnan(order) else f"{order:.1f}"]
        lines.append([*line, ", ".join(_percent(value(method, "", level, "swap")) for level in LEVELS)])
    return Sheet(("method", "disc slave", "order", "block slave", "order", "swap"), lines)


def _cones(rows: list[Row]) -> Sheet:
    """Both cones beside each other: errors, the lowest pressure over the largest one, and iterations."""
    value, lines = _Values(rows), []
    for method in METHODS:
        if f"{method}, strong cone" in CONES or method in CONES:
            for slave in SLAVES:
                errors, lowest, iterations = (
                    [value(method, slave, level, quantity) for level in LEVELS]
                    for quantity in ("error", "lowest", "iterations")
                )
                told = [", ".join(map(_percent, values)) for values in (errors, lowest)]
                lines.append([_named(method), slave, *told, ", ".join(f"{count:.0f}" for count in iterations)])
    return Sheet(("method", "slave", "error", "lowest pressure", "iterations"), lines)


def _named(method: str) -> str:
    name, _, cone = method.partition(",")
    return f"`{name}`,{cone}" if cone else f"`{name}`"


def _costs(rows: list[Row]) -> Sheet:
    """CPU times, and those over the ones of mortar-p0."""
    value, lines = _Values(rows), []
    kinds = list(zip(COSTS, (FINEST, FINEST, 1, 1), (1e3, 1e6, 1e6, 1e6), strict=True))
    for method in METHODS:
        line = [_named(method)]
        for kind, level, scale in kinds:
            spent, base = (value(name, "disc", level, kind) for name in (method, BASE))
            line.append("" if np.isnan(spent) else f"{scale * spent:.3g} ({spent / base:.2f})")
        if any(line[1:]):
            lines.append(line)
    each = "its contact per node [us]"
    return Sheet(("method", "iteration [ms]", each, "step [us]", each), lines)


def _equal(rows: list[Row]) -> Sheet:
    """CPU time at each target by contender and case."""
    cases, contenders = (list(dict.fromkeys(row[name] for row in rows)) for name in ("case", "contender"))
    targets = sorted({row["target"] for row in rows}, key=float, reverse=True)
    found = {(row["contender"], row["case"], row["target"]): row for row in rows}
    lines = [
        [f"`{one}`", *(_at_errors([found.get((one, case, target)) for target in targets]) for case in cases)]
        for one in contenders
    ]
    head = " / ".join(_percent(float(target)) for target in targets)
    return Sheet((f"at {head} %", *cases), lines)


def _at_errors(costs: list[Row | None]) -> str:
    """CPU times at all targets, the largest first; nothing if the case was not asked."""
    if None in costs:
        return ""
    said = [_at_error(cost) for cost in costs if cost]
    return said[0] if len(set(said)) == 1 and "failed" in said else " / ".join(said)


def _at_error(cost: Row) -> str:
    """A CPU time, or in parentheses the error of the finest mesh that was run."""
    if cost["kind"] == "reached":
        return ("≤ " if cost["coarsest"] == "True" else "") + f"{float(cost['cost']):.2g}"
    if cost["kind"] == "grey":
        return "…"
    best = re.search(r"([\d.e-]+) % at level", cost["why"])
    return f"({best[1]} %)" if best else cost["kind"].replace("-", " ")


def _cases(cases: list[Row]) -> Sheet:
    """What the quick matrix has: some numbers, and the cases that were not met."""
    lines = []
    for method in dict.fromkeys((*PLAIN, *sorted(row["contact"] for row in cases))):
        own = [row for row in cases if row["contact"] == method and not row["variant"]]
        found = {(row["case"], row["measure"]): row["value"] for row in own}
        cells = {row["case"]: row["cell"] for row in own}
        line = [f"`{method}`", *(found.get(pair, "") for pair in CASES.items())]
        line += [_largest(own, PENETRATION), _largest(own, SAW), f"{Counter(cells.values())['met']} of {len(cells)}"]
        lines.append([*line, ", ".join(f"{case} ({said})" for case, said in cells.items() if said != "met")])
    head = (
        "method", "patch: stress", "Hertz: L2", "rings: order of pressure", "of shear", "ironing: iterations",
        "deepest penetration, segments", "largest saw-tooth", "met", "others",
    )  # fmt: skip
    return Sheet(head, lines)


def _largest(rows: list[Row], measure: str) -> str:
    return max((row["value"] for row in rows if row["measure"] == measure), key=float, default="")


def main() -> None:
    """Measure and keep."""
    wish = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    wish.add_argument("methods", nargs="*", help="errors of these alone; what else is kept stays")
    wish.add_argument("--costs", action="store_true", help="costs of these methods as well")
    wish.add_argument("--turns", type=int, default=3)
    wish.add_argument("--equal", type=Path, help="folder of a comparison whose costs at equal errors are kept")
    given = wish.parse_args()
    if given.equal:
        keep_equal(given.equal)
        return
    if given.methods:
        rows = [row for row in stored() if row["method"] not in given.methods or row["quantity"] in COSTS]
        if given.costs:
            rows = [row for row in rows if row["method"] not in given.methods]
            rows += scaled_costs(given.turns, given.methods, rows)
    else:
        rows = costs(given.turns, METHODS)
    for method in given.methods or METHODS:
        for level in LEVELS:
            rows += accuracies(method, level)
            print(method, level, rows[-1]["value"], flush=True)
        write_csv(KEPT, COLUMNS, rows)


if __name__ == "__main__":
    main()
