"""Disc on block with CalculiX, an independent free code: nodes on segments by penalty, on the same meshes.

    apt-get install calculix-ccx
    python3 benchmarks/peers/calculix_disc_on_block.py --level 2 --slave disc

One layer of eight-node bricks held in z, which is plane strain with 2 x 2 points; contact pair of type NODE TO SURFACE
with a linear pressure over the overclosure. The law is CalculiX' neo-Hookean one (`calculix_law.py` for contactlab).
Nothing of contactlab is imported. Writes deformed x, pressure and the reaction to benchmarks/references.
"""

from __future__ import annotations

import argparse
import re
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

OUT = Path(__file__).parents[1] / "references"
STIFFNESS = 1e7  # MPa/mm: 2000 MPa come with 0.0002 mm, 1 % of a segment at level 2


def disc(level: int) -> tuple[np.ndarray, int, int]:
    """Between the arc of radius 1, |x| <= 0.8, and y = 0.6; columns of equal width."""
    columns, rows = 24 * level, 6 * level
    s, t = np.meshgrid(np.linspace(-0.8, 0.8, columns + 1), np.linspace(0.0, 1.0, rows + 1))
    low = 1.0 - np.sqrt(1.0 - s * s)
    return np.stack([s, low + t * (0.6 - low)], axis=-1).reshape(-1, 2), columns, rows


def block(level: int) -> tuple[np.ndarray, int, int]:
    """1.8 by 0.3, its top at y = 0."""
    columns, rows = 36 * level, 6 * level
    x, y = np.meshgrid(np.linspace(-0.9, 0.9, columns + 1), np.linspace(-0.3, 0.0, rows + 1))
    return np.stack([x, y], axis=-1).reshape(-1, 2), columns, rows


def deck(level: int, slave: str, depth: float, stiffness: float) -> tuple[str, np.ndarray, float]:
    """The input of CalculiX, number and undeformed place (n, 3) of the slave's nodes at z = 0, and the thickness."""
    thickness = 1.0 / (30.0 * level)
    text, first, cells_before, layers = ["*NODE, NSET=ALL"], {}, {}, {}
    bodies = {"disc": disc(level), "block": block(level)}
    count = sum(len(nodes) for nodes, _, _ in bodies.values())
    start = 1
    for name, (nodes, _, _) in bodies.items():
        first[name] = start
        for layer in range(2):
            text += [f"{start + layer * count + i}, {x:.15g}, {y:.15g}, {layer * thickness:.15g}"
                     for i, (x, y) in enumerate(nodes)]  # fmt: skip
        start += len(nodes)
    start = 1
    for name, (_, columns, rows) in bodies.items():
        cells_before[name] = start
        text.append(f"*ELEMENT, TYPE=C3D8, ELSET={name}")
        for j in range(rows):
            for i in range(columns):
                a = first[name] + j * (columns + 1) + i
                flat = [a, a + 1, a + columns + 2, a + columns + 1]
                text.append(f"{start}, " + ", ".join(str(n) for n in flat + [n + count for n in flat]))
                start += 1
    for name, young in (("disc", 70000.0), ("block", 7000.0)):
        shear, bulk = young / 2.6, young / (3.0 * 0.4)
        text += [f"*MATERIAL, NAME=M{name}", "*HYPERELASTIC, NEO HOOKE", f"{0.5 * shear:.15g}, {2.0 / bulk:.15g}",
                 f"*SOLID SECTION, ELSET={name}, MATERIAL=M{name}"]  # fmt: skip
    faces, rim = {}, {}
    for name, (_, columns, rows) in bodies.items():
        row, face = (0, "S3") if name == "disc" else (rows - 1, "S5")
        faces[name] = [f"{cells_before[name] + row * columns + i}, {face}" for i in range(columns)]
        at = first[name] + (0 if name == "disc" else rows * (columns + 1))
        rim[name] = np.arange(at, at + columns + 1)
        held = first[name] + (rows * (columns + 1) if name == "disc" else 0)
        layers[name] = [held + i + layer * count for layer in range(2) for i in range(columns + 1)]
    master = "block" if slave == "disc" else "disc"
    text += ["*SURFACE, NAME=SLAVE", *faces[slave], "*SURFACE, NAME=MASTER", *faces[master]]
    for name in bodies:
        text += [f"*NSET, NSET=HELD{name}", *map(str, layers[name])]
    text += ["*NSET, NSET=RIM", *map(str, rim[slave]), "*SURFACE INTERACTION, NAME=PENALTY",
             "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{stiffness:.6g}, 1e-3",
             "*CONTACT PAIR, INTERACTION=PENALTY, TYPE=NODE TO SURFACE", "SLAVE, MASTER",
             "*BOUNDARY", "ALL, 3, 3", "HELDblock, 1, 2", "HELDdisc, 1, 1",
             "*STEP, NLGEOM, INC=1000", "*STATIC", "0.02, 1.0, 1e-5, 0.05",
             "*BOUNDARY", f"HELDdisc, 2, 2, {-depth}",
             "*NODE PRINT, NSET=RIM", "U", "*NODE PRINT, NSET=HELDblock, TOTALS=ONLY", "RF",
             "*CONTACT PRINT, FREQUENCY=1", "CSTR", "*END STEP"]  # fmt: skip
    at = rim[slave] - first[slave]
    return "\n".join(text) + "\n", np.column_stack([rim[slave], bodies[slave][0][at]]), thickness


def solve(level: int, slave: str, depth: float, stiffness: float) -> tuple[np.ndarray, np.ndarray, float, str]:
    """Deformed x and pressure of the slave's nodes, vertical reaction per thickness, version."""
    text, rim, thickness = deck(level, slave, depth, stiffness)
    with TemporaryDirectory() as folder:
        (Path(folder) / "run.inp").write_text(text)
        done = subprocess.run(["ccx", "run"], cwd=folder, capture_output=True, text=True, check=False)
        states = blocks((Path(folder) / "run.dat").read_text())
    version = re.search(r"Version (\S+),", done.stdout)
    time = max(states)
    if time < 1.0:
        raise SystemExit(f"CalculiX stopped at {100 * time:.3g} % of the load: increments below the smallest allowed")
    moved, pressed, held = states[time]["displacements"], states[time]["contact"], states[time]["forces"]
    number, before = rim[:, 0].astype(int), rim[:, 1:]
    x = before[:, 0] + np.array([moved[n][0] for n in number])
    pressure = np.array([max(pressed.get(n, (0.0,))[0], 0.0) for n in number])
    return x, pressure, abs(held[0][1]) / thickness, version[1] if version else "of unknown version"


def blocks(text: str) -> dict[float, dict[str, dict[int, tuple[float, ...]]]]:
    """By load and kind, the numbers of every node; totals have node 0."""
    found: dict[float, dict[str, dict[int, tuple[float, ...]]]] = {}
    rows: dict[int, tuple[float, ...]] = {}
    for line in text.splitlines():
        head = re.match(r"\s*(?:total )?(displacements|contact|force)s?\b.*time\s+(\S+)", line)
        values = line.split()
        if head:
            kind = "forces" if head[1] == "force" else head[1]
            rows = found.setdefault(float(head[2]), {}).setdefault(kind, {})
        elif values and not values[0][0].isalpha():
            number, rest = (0, values) if len(values) == 3 else (int(values[0]), values[1:])
            rows[number] = tuple(float(value) for value in rest)
    return found


def main() -> None:
    """Solve and write the curve."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--level", type=int, default=2)
    parser.add_argument("--slave", choices=("disc", "block"), default="disc")
    parser.add_argument("--depth", type=float, default=0.02)
    parser.add_argument("--stiffness", type=float, default=STIFFNESS, help="of the penalty [MPa/mm]")
    given = parser.parse_args()
    x, pressure, reaction, version = solve(given.level, given.slave, given.depth, given.stiffness)
    path = OUT / f"calculix-disc-on-block-{given.slave}-level-{given.level}-depth-{given.depth:g}.csv"
    header = f"x,pressure; CalculiX {version}, penalty {given.stiffness:g} MPa/mm, reaction {reaction:.6g} N/mm"
    np.savetxt(path, np.column_stack([x, pressure]), delimiter=",", header=header, fmt="%.9g")
    print(header)


if __name__ == "__main__":
    main()
