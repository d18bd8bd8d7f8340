"""The nodes that gap conditions touch, numbered among themselves."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel


@kernel
def number_nodes(node, local, touched, count):
    """List what of `node` is not yet among the first `count` of `touched`, and number it in `local` (N,).

    `local` is -1 where nothing has been numbered, negative nodes are skipped; returns the new count.
    """
    for n in node:
        if n >= 0 and local[n] < 0:
            local[n] = count
            touched[count] = n
            count += 1
    return count


@kernel
def largest_correction(node, compliance, force):
    """Largest displacement [mm] that the forces give to any of these nodes."""
    largest = 0.0
    for n in node:
        largest = max(largest, abs(compliance[n, 0] * force[n, 0]), abs(compliance[n, 1] * force[n, 1]))
    return largest
