"""What a triad measured, from what it put out: effects corrected, a sample after the other.

    N / k = b + (1 + s) (E u + D) + e(u)

``b`` and ``s`` are polynomials of signals such as temperature, and do not depend on u; ``e(u)`` is of the sensor's
own input, but for cross products. Newton's method with each sensor's own slope: two or three rounds, as E couples
the sensors by little. numba compiles what is here; it allocates nothing.
"""

from math import cos, cosh, isfinite, nan, sin, sinh, sqrt

from procedures.arrays import BoolArray, FloatArray
from procedures.attitude.kernel_options import inlined, kernel

MAX_ROUNDS = 100
SETTLED = 1e-13  # relative, and of g or deg/s
SERIES_BELOW = 1e-3  # of (s u)^2, below which the sine's series is used
LARGEST = 1e12  # g, deg/s: beyond it nothing settles


@inlined
def _polynomial(coefficients: FloatArray, signals: FloatArray, sensor: int, i: int) -> float:
    """Return the sum of polynomials (signals, 3, orders) without a constant; an unknown signal adds nothing."""
    total = 0.0
    for m in range(coefficients.shape[0]):
        x = signals[m, i]
        if isfinite(x):
            part = 0.0
            for n in range(coefficients.shape[2] - 1, -1, -1):
                part = (part + coefficients[m, sensor, n]) * x
            total += part
    return total


@inlined
def _sine(q: float, u: float) -> tuple[float, float]:
    """Return ``sin(s u) / s - u`` for q = s^2, of a negative q with sinh, and its slope by u."""
    y = q * u * u
    if abs(y) < SERIES_BELOW:
        return (u * y * (-1 / 6 + y * (1 / 120 - y / 5040)), y * (-1 / 2 + y * (1 / 24 - y / 720)))
    x = sqrt(abs(y))
    if y > 0:
        return u * (sin(x) / x - 1.0), cos(x) - 1.0
    return u * (sinh(x) / x - 1.0), cosh(x) - 1.0


@inlined
def _of_input(powers: FloatArray, sensor: int, u: float) -> tuple[float, float]:
    """Return e(u) = a |u| + b u^2 + c u |u| + d u^3 + a sine, and its slope; ``powers`` (5, 3): a, b, c, d, q."""
    size = abs(u)
    sign = 1.0 if u >= 0 else -1.0
    value = powers[0, sensor] * size + (powers[1, sensor] + powers[3, sensor] * u) * u * u
    value += powers[2, sensor] * u * size
    slope = powers[0, sensor] * sign + 2 * (powers[1, sensor] * u + powers[2, sensor] * size)
    slope += 3 * powers[3, sensor] * u * u
    if powers[4, sensor] != 0:
        sine, by_u = _sine(powers[4, sensor], u)
        value += sine
        slope += by_u
    return value, slope


@kernel
def settle(
    output: FloatArray, E: FloatArray, inverse: FloatArray, D: FloatArray, bias: FloatArray, scale: FloatArray,
    signals: FloatArray, extra: FloatArray, matrix: FloatArray, vector: FloatArray, powers: FloatArray,
    cross: FloatArray, work: FloatArray, found: FloatArray, unsettled: BoolArray,
) -> None:  # fmt: skip
    """Write u (n, 3) [g], [deg/s] into ``found``; a sample that does not settle is nan, and ``unsettled`` (n,).

    Parameters
    ----------
    output : (n, 3), N / k [g], [deg/s]
    E, inverse : (3, 3), misalignment, rows sensors, and its inverse
    D : (3,) [g], [deg/s]
    bias, scale : (signals, 3, orders), polynomials of the signals, from the first power on
    signals : (signals, n), nan where not known
    extra : (n, 3) or (0, 3) [g], [deg/s], added to the output in addition
    matrix, vector : (3, 3) and (n, 3) or (0, 3), whose product is added too
    powers : (5, 3), `_of_input`
    cross : (3, 3), of u_x u_y, u_x u_z, u_y u_z, a row a sensor
    work : (4, 3), scratch
    """
    is_linear = True
    for q in range(3):
        for n in range(powers.shape[0]):
            is_linear = is_linear and powers[n, q] == 0
        for n in range(3):
            is_linear = is_linear and cross[q, n] == 0
    for i in range(output.shape[0]):
        for q in range(3):
            b = _polynomial(bias, signals, q, i)
            if extra.shape[0]:
                b += extra[i, q]
            if vector.shape[0]:
                b += matrix[q, 0] * vector[i, 0] + matrix[q, 1] * vector[i, 1] + matrix[q, 2] * vector[i, 2]
            work[0, q] = output[i, q] - b  # what is left: (1 + s) (E u + D) + e(u)
            work[1, q] = 1.0 + _polynomial(scale, signals, q, i)
            work[2, q] = work[0, q] / work[1, q] - D[q] if work[1, q] != 0 else nan
        for q in range(3):
            found[i, q] = inverse[q, 0] * work[2, 0] + inverse[q, 1] * work[2, 1] + inverse[q, 2] * work[2, 2]
        is_zero = work[1, 0] == 0 or work[1, 1] == 0 or work[1, 2] == 0
        if is_zero or (not is_linear and not _settled(i, E, inverse, D, powers, cross, work, found)):
            unsettled[i] = True
            found[i, :] = nan


@inlined
def _settled(
    i: int, E: FloatArray, inverse: FloatArray, D: FloatArray, powers: FloatArray, cross: FloatArray,
    work: FloatArray, found: FloatArray,
) -> bool:  # fmt: skip
    """Go on from the solution without e(u) until it stands still; an output that is no number stays none."""
    for _ in range(MAX_ROUNDS):
        x, y, z = found[i, 0], found[i, 1], found[i, 2]
        if not isfinite(work[0, 0] + work[0, 1] + work[0, 2]):
            return True
        for q in range(3):
            value, slope = _of_input(powers, q, found[i, q])
            value += cross[q, 0] * x * y + cross[q, 1] * x * z + cross[q, 2] * y * z
            put_out = E[q, 0] * x + E[q, 1] * y + E[q, 2] * z + D[q]
            by_output = work[1, q] + slope / E[q, q]
            if by_output == 0:
                return False
            work[2, q] = (work[0, q] - work[1, q] * put_out - value) / by_output
        is_done = True
        for q in range(3):
            step = inverse[q, 0] * work[2, 0] + inverse[q, 1] * work[2, 1] + inverse[q, 2] * work[2, 2]
            found[i, q] += step
            if not abs(found[i, q]) < LARGEST:
                return False
            if abs(step) > SETTLED * (1.0 + abs(found[i, q])):
                is_done = False
        if is_done:
            return True
    return False
