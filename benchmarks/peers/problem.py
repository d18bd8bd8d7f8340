"""What all codes are given: the mesh, the law, the motion, and how time is taken."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from statistics import median
from time import process_time
from typing import Any

import numpy as np

ELASTIC = {"young": 70000.0, "poisson": 0.3, "density": 2.7e-9}
SPEED = 100.0  # mm/s over the block: strains stay small in all the steps that are made


def quads(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (N, 2) and counter-clockwise cells (n, 4) of a square of about so many unit cells."""
    columns = round(cells**0.5)
    rows = -(-cells // columns)
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    return np.stack([x.ravel(), y.ravel()], axis=1), np.stack(
        [first, first + 1, first + columns + 2, first + columns + 1], axis=1
    )


def velocities(nodes: np.ndarray) -> np.ndarray:
    """A uniform flow (N, 2) [mm/s] that stretches and shears the block."""
    return SPEED * nodes @ np.array([[1.0, 0.3], [-0.2, -0.9]]).T / nodes.max()


def arguments(text: str | None) -> Any:
    """--cells and --rounds."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=5)
    return parser.parse_args()


def report(code: str, version: str, cells: int, step: Callable[[], Any], rounds: int) -> None:
    """Time rounds of about 200 000 updates and print them; CPU time of the process, which has one thread."""
    number = max(2, 200_000 // cells)
    for _ in range(max(2, number // 4)):
        step()
    seconds = []
    for _ in range(rounds):
        began = process_time()
        for _ in range(number):
            step()
        seconds.append((process_time() - began) / number)
    row = {"code": code, "version": version, "cells": cells, "seconds": seconds, "median": median(seconds)}
    print(json.dumps(row), flush=True)
