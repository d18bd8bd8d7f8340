"""Kernels of the bilinear quadrilateral with one point, and its stabilisation against hourglassing.

With the coefficients of q1_kernels, f = (F0 + F1 xi + F2 eta + F3 xi eta)/4, the hourglass amplitude of a
displacement u is q = (U3 - X3 u_x - Y3 u_y)/4 (gradient at the centre): zero for every linear field.
"""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel
from contactlab_quads.q1_kernels import gather, scatter


@kernel
def gradient(geometry, field, connectivity, out, scratch):
    """d(field)/d(geometry) (4, B) at the centre."""
    gather(geometry, field, connectivity, scratch)
    s, xx, xy, yx, yy = scratch, out[0], out[1], out[2], out[3]
    x1, x2, y1, y2, u1, u2, v1, v2 = s[0], s[1], s[3], s[4], s[6], s[7], s[9], s[10]
    for c in range(connectivity.shape[1]):
        inverse = 1.0 / (x1[c] * y2[c] - x2[c] * y1[c])
        xx[c] = (u1[c] * y2[c] - u2[c] * y1[c]) * inverse
        xy[c] = (u2[c] * x1[c] - u1[c] * x2[c]) * inverse
        yx[c] = (v1[c] * y2[c] - v2[c] * y1[c]) * inverse
        yy[c] = (v2[c] * x1[c] - v1[c] * x2[c]) * inverse


@kernel
def force(geometry, connectivity, stress, force, scratch):
    """Add the nodal forces of `stress` (4, B); the map's coefficients are still in `scratch`."""
    s, sxx, syy, sxy = scratch, stress[0], stress[1], stress[3]
    x1, x2, y1, y2 = s[0], s[1], s[3], s[4]
    fx1, fx2, fx3, fy1, fy2, fy3 = s[6], s[7], s[8], s[9], s[10], s[11]
    for c in range(connectivity.shape[1]):
        fx1[c] = 0.25 * (sxx[c] * y2[c] - sxy[c] * x2[c])
        fx2[c] = 0.25 * (sxy[c] * x1[c] - sxx[c] * y1[c])
        fy1[c] = 0.25 * (sxy[c] * y2[c] - syy[c] * x2[c])
        fy2[c] = 0.25 * (syy[c] * x1[c] - sxy[c] * y1[c])
        fx3[c], fy3[c] = 0.0, 0.0
    scatter(connectivity, scratch, force)


@kernel
def _resist(modulus, x1, x2, x3, y1, y2, y3, u1, u2, u3):
    """Replace a component's coefficients by its hourglass force's."""
    for c in range(x1.size):
        inverse = 1.0 / (x1[c] * y2[c] - x2[c] * y1[c])
        k = modulus * (x1[c] * x1[c] + x2[c] * x2[c] + y1[c] * y1[c] + y2[c] * y2[c]) * inverse
        # 4 q = u3 - along u1 - across u2, and forces go the same way back
        along, across = (x3[c] * y2[c] - y3[c] * x2[c]) * inverse, (y3[c] * x1[c] - x3[c] * y1[c]) * inverse
        f = 0.0625 * k * (u3[c] - along * u1[c] - across * u2[c])
        u1[c], u2[c], u3[c] = -along * f, -across * f, f


@kernel
def stabilise(reference, displacement, connectivity, modulus, force, scratch):
    """Add k q gamma, k = modulus A (b_x.b_x + b_y.b_y), on the undeformed geometry."""
    s = scratch
    gather(reference, displacement, connectivity, s)
    _resist(modulus, s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8])
    _resist(modulus, s[0], s[1], s[2], s[3], s[4], s[5], s[9], s[10], s[11])
    scatter(connectivity, s, force)
