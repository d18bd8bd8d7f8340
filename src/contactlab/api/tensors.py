"""Vectors and tensors of the plane for formulas: a handful of numbers with the usual arithmetic.

Their components are numbers, or dual numbers when a formula is differentiated.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from contactlab.api.mathematics import sqrt

Number = Any
"""A float, or a dual number when a formula is differentiated."""


class Vector(NamedTuple):
    """A vector (x, y): `a + b`, `2.0 * a`, `a @ b` (dot), `a.cross(b)`, `a.length()`, `a.unit()`, `a.turned()`."""

    x: Number
    y: Number

    def __add__(self, other: Vector) -> Vector:  # type: ignore[override]
        return Vector(self.x + other.x, self.y + other.y)

    def __sub__(self, other: Vector) -> Vector:
        return Vector(self.x - other.x, self.y - other.y)

    def __mul__(self, number: Number) -> Vector:
        return Vector(self.x * number, self.y * number)

    def __rmul__(self, number: Number) -> Vector:
        return self.__mul__(number)

    def __truediv__(self, number: Number) -> Vector:
        return self.__mul__(1.0 / number)

    def __neg__(self) -> Vector:
        return Vector(-self.x, -self.y)

    def __matmul__(self, other: Vector) -> Number:
        return self.x * other.x + self.y * other.y

    def cross(self, other: Vector) -> Number:
        """Return the third component of the cross product."""
        return self.x * other.y - self.y * other.x

    def turned(self) -> Vector:
        """Return the vector turned by -90 degrees: the outward normal of a side that has the body on its left."""
        return Vector(self.y, -self.x)

    def length(self) -> Number:
        """Return its length."""
        return sqrt(self.x * self.x + self.y * self.y)

    def unit(self) -> Vector:
        """Return the unit vector along it."""
        scale = 1.0 / sqrt(self.x * self.x + self.y * self.y)
        return Vector(self.x * scale, self.y * scale)


class Tensor(NamedTuple):
    """A tensor of plane strain, with rows (xx, xy, 0), (yx, yy, 0), (0, 0, zz).

    `A + B`, `2.0 * A`, `A / J`, `A @ B` (product), `A @ v`, `A.T()`, `A.det()`, `A.trace()`, `A.inverse()`,
    `A.symmetric()`, `A.deviator()`, `A.dot(B)` (sum of the products of all components).
    """

    xx: Number
    xy: Number
    yx: Number
    yy: Number
    zz: Number

    def __add__(self, other: Tensor) -> Tensor:  # type: ignore[override]
        return Tensor(*(a + b for a, b in zip(self, other, strict=True)))

    def __sub__(self, other: Tensor) -> Tensor:
        return Tensor(*(a - b for a, b in zip(self, other, strict=True)))

    def __mul__(self, number: Number) -> Tensor:
        return Tensor(*(a * number for a in self))

    def __rmul__(self, number: Number) -> Tensor:
        return self.__mul__(number)

    def __truediv__(self, number: Number) -> Tensor:
        return self.__mul__(1.0 / number)

    def __neg__(self) -> Tensor:
        return Tensor(*(-a for a in self))

    def __matmul__(self, other: Any) -> Any:
        if isinstance(other, Vector):
            return Vector(self.xx * other.x + self.xy * other.y, self.yx * other.x + self.yy * other.y)
        return Tensor(
            self.xx * other.xx + self.xy * other.yx, self.xx * other.xy + self.xy * other.yy,
            self.yx * other.xx + self.yy * other.yx, self.yx * other.xy + self.yy * other.yy, self.zz * other.zz,
        )  # fmt: skip

    def T(self) -> Tensor:
        """Return its transpose."""
        return Tensor(self.xx, self.yx, self.xy, self.yy, self.zz)

    def trace(self) -> Number:
        """Return the sum of the diagonal."""
        return self.xx + self.yy + self.zz

    def det(self) -> Number:
        """Return its determinant."""
        return (self.xx * self.yy - self.xy * self.yx) * self.zz

    def inverse(self) -> Tensor:
        """Return its inverse."""
        scale = 1.0 / (self.xx * self.yy - self.xy * self.yx)
        return Tensor(self.yy * scale, -self.xy * scale, -self.yx * scale, self.xx * scale, 1.0 / self.zz)

    def symmetric(self) -> Tensor:
        """Return its symmetric part."""
        shear = 0.5 * (self.xy + self.yx)
        return Tensor(self.xx, shear, shear, self.yy, self.zz)

    def deviator(self) -> Tensor:
        """Return the tensor less a third of its trace on the diagonal."""
        mean = (self.xx + self.yy + self.zz) / 3.0
        return Tensor(self.xx - mean, self.xy, self.yx, self.yy - mean, self.zz - mean)

    def dot(self, other: Tensor) -> Number:
        """Return the sum of the products of all components."""
        return (
            self.xx * other.xx + self.xy * other.xy + self.yx * other.yx + self.yy * other.yy + self.zz * other.zz
        )  # fmt: skip


UNIT: Final = Tensor(1.0, 0.0, 0.0, 1.0, 1.0)
"""The unit tensor."""

for _kind in (Vector, Tensor):
    setattr(_kind, "__array_ufunc__", None)  # noqa: B010  a NumPy number leaves the product to them
