"""Unit costs: the model that costs are a sum of counted work, each kind with a price of its own."""

from __future__ import annotations

import numpy as np

from contactlab.api.arrays import Floats


def unit_costs(work: Floats, cost: Floats, rest: Floats | None = None) -> Floats:
    """Prices (u,) >= 0 of u kinds of work from n runs with the `work` (n, u) and the `cost` (n,).

    `rest` (n,) is the part of the cost that these kinds of work explain; not given: all of it. Least squares of errors
    relative to the cost: a cheap run counts as much as a dear one (Lawson & Hanson 1974, ch. 23).
    """
    from scipy.optimize import nnls

    found: Floats = nnls(work / cost[:, None], np.ones(len(cost)) if rest is None else rest / cost)[0]
    return found
