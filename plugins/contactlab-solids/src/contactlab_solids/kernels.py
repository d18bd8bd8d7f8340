"""Block kernels of the laws: gradient rows in, stress rows out."""

from __future__ import annotations

from contactlab.api.compiled.kernel import kernel, log


@kernel
def linear_elastic(gradient, stress, lame, shear):
    """Compute Hooke's stress rows from the rows of du/dX."""
    u_x, u_y, v_x, v_y = gradient[0], gradient[1], gradient[2], gradient[3]
    xx, yy, zz, xy = stress[0], stress[1], stress[2], stress[3]
    for p in range(u_x.size):
        pressure = lame * (u_x[p] + v_y[p])
        xx[p] = pressure + 2.0 * shear * u_x[p]
        yy[p] = pressure + 2.0 * shear * v_y[p]
        zz[p] = pressure
        xy[p] = shear * (u_y[p] + v_x[p])


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


@kernel
def neo_hookean_energy(gradient, energy, lame, shear):
    """Stored energy per current volume, W/J."""
    f_xx, f_xy, f_yx, f_yy = gradient[0], gradient[1], gradient[2], gradient[3]
    for p in range(f_xx.size):
        a, b, c, d = f_xx[p], f_xy[p], f_yx[p], f_yy[p]
        inverse_j = a * d - b * c
        log_j = -log(inverse_j)
        trace = (a * a + b * b + c * c + d * d) / (inverse_j * inverse_j) + 1.0
        energy[p] = inverse_j * (0.5 * shear * (trace - 3.0 - 2.0 * log_j) + 0.5 * lame * log_j * log_j)


@kernel
def neo_hookean_tangent(gradient, tangent, lame, shear):
    """d(stress row)/d(row of F^-1): the derivative of `neo_hookean` by a, b, c, d and their determinant."""
    f_xx, f_xy, f_yx, f_yy = gradient[0], gradient[1], gradient[2], gradient[3]
    for p in range(f_xx.size):
        a, b, c, d = f_xx[p], f_xy[p], f_yx[p], f_yy[p]
        inverse_j = a * d - b * c
        scale = shear / inverse_j
        # derivatives by the determinant, whose own derivatives are d, -c, -b, a
        spherical = -(lame * log(inverse_j) + shear + lame)
        ratio = scale / inverse_j
        xx = spherical - ratio * (d * d + b * b)
        yy = spherical - ratio * (a * a + c * c)
        zz = spherical + shear
        xy = ratio * (c * d + a * b)
        tangent[0, 0, p], tangent[0, 1, p] = xx * d, 2.0 * scale * b - xx * c
        tangent[0, 2, p], tangent[0, 3, p] = -xx * b, xx * a + 2.0 * scale * d
        tangent[1, 0, p], tangent[1, 1, p] = yy * d + 2.0 * scale * a, -yy * c
        tangent[1, 2, p], tangent[1, 3, p] = 2.0 * scale * c - yy * b, yy * a
        tangent[2, 0, p], tangent[2, 1, p] = zz * d, -zz * c
        tangent[2, 2, p], tangent[2, 3, p] = -zz * b, zz * a
        tangent[3, 0, p], tangent[3, 1, p] = xy * d - scale * b, -xy * c - scale * a
        tangent[3, 2, p], tangent[3, 3, p] = -xy * b - scale * d, xy * a - scale * c
