"""Kernel of the neo-Hookean law: gradient rows in, stress rows out."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, log


@kernel
def neo_hookean(gradient, stress, lame, shear):
    """Compressible neo-Hookean: Cauchy stress rows from the rows a, b, c, d of F^-1.

    F = [[d, -b], [-c, a]]/det(F^-1) and J = 1/det(F^-1), so b = F F^T needs no inverse.
    """
    f_xx, f_xy, f_yx, f_yy = gradient[0], gradient[1], gradient[2], gradient[3]
    xx, yy, zz, xy = stress[0], stress[1], stress[2], stress[3]
    for p in range(f_xx.size):
        a, b, c, d = f_xx[p], f_xy[p], f_yx[p], f_yy[p]
        inverse_j = a * d - b * c
        j = 1.0 / inverse_j
        # (lambda ln J - mu)/J and mu J: b = J^2 (adj F^-1)(adj F^-1)^T
        spherical = -(lame * log(inverse_j) + shear) * inverse_j
        scale = shear * j
        xx[p] = spherical + scale * (d * d + b * b)
        yy[p] = spherical + scale * (a * a + c * c)
        zz[p] = spherical + shear * inverse_j
        xy[p] = -scale * (c * d + a * b)
