"""Sine, cosine and arctangent that give the same bits on every processor.

Those of the C library and of NumPy do not: with and without fused multiply-add or wide
vectors the last bit differs, and a cleaning run that differs in one bit is soon another
run. These use nothing but additions, multiplications and divisions, which IEEE 754
defines to the bit.

For the same reason there are no matrix products where the bits matter (BLAS adds in another
order on other processors): of two vectors ``(a * b).sum(axis=-1)`` is taken.
"""

from __future__ import annotations

import math

__all__ = ["arctangent", "sine_cosine"]

_QUARTER_HIGH, _QUARTER_LOW = 1.57079632673412561417, 6.07710050650619224932e-11
"""A quarter turn in two parts; the first has 33 bits, so that small multiples are exact."""


def sine_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle, rad, of at most a million turns; to 1e-16 or so."""
    quarters = math.floor(angle * (2.0 / math.pi) + 0.5)
    x = (angle - quarters * _QUARTER_HIGH) - quarters * _QUARTER_LOW
    z = x * x
    # Minimax polynomials on ±45°, those of Sun's fdlibm.
    sine = -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10
    sine = -1.98412698298579493134e-04 + z * (2.75573137070700676789e-06 + z * sine)
    sine = -1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * sine)
    sine = x + x * z * sine
    cosine = 2.08757232129817482790e-09 + z * -1.13596475577881948265e-11
    cosine = 2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 + z * cosine)
    cosine = 4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * cosine)
    cosine = 1.0 - (0.5 * z - z * z * cosine)
    turn = quarters % 4
    if turn == 0:
        return sine, cosine
    if turn == 1:
        return cosine, -sine
    if turn == 2:
        return -sine, -cosine
    return -cosine, sine


def arctangent(y: float, x: float) -> float:
    """Direction of the vector (x, y), rad, in [-pi, pi]; 0 for the null vector."""
    if x == 0.0 and y == 0.0:
        return 0.0
    over, under = min(abs(x), abs(y)), max(abs(x), abs(y))
    # atan(t) = 45° + atan((t - 1) / (t + 1)) brings the ratio to ±0.21 or below 0.66.
    shift = over > 0.66 * under
    t = (over - under) / (over + under) if shift else over / under
    z = t * t
    # A rational approximation, that of Moshier's Cephes.
    above = -1.615753718733365076637e1 + z * -8.750608600031904122785e-1
    above = -1.228866684490136173410e2 + z * (-7.500855792314704667340e1 + z * above)
    above = -6.485021904942025371773e1 + z * above
    below = 1.650270098316988542046e2 + z * (2.485846490142306297962e1 + z)
    below = 4.853903996359136964868e2 + z * (4.328810604912902668951e2 + z * below)
    below = 1.945506571482613964425e2 + z * below
    angle = t + t * (z * above / below)
    if shift:
        angle += 0.25 * math.pi
    if abs(y) > abs(x):
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    return angle if y >= 0.0 else -angle
