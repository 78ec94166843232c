"""Functions without a name: smooth in a coordinate of what the sensors went through, as Gaussian processes.

A function of a coordinate x in [0, 1] is a sum of cosines cos(pi k x) whose variances fall as
(1 + (k / b)^2)^-2, the spectrum of a cubic smoothing spline beyond b half periods: small b for trends, large b
for waves. It acts on a triad's three sensors or on one, on the bias or on the scale factor.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.effects.bias_noise import MOST_DRAWS
from procedures.effects.excitation import REFERENCE_C, Columns, Excitation, per_axis
from procedures.effects.temperature_history import REVERSAL_K, lagged, sensor_temperature
from procedures.evidence.residual_rows import Evidence
from procedures.evidence.row_sums import row_sums
from procedures.frames import AXES, TRIADS
from procedures.inference import priors
from procedures.units import S_PER_H

RESTING = ("dwell", "rest")

PARTS = 4  # of a dwell or rest, before each of which a walk steps


def walk_columns(evidence: Evidence, triad: str, parts: int = 1) -> FloatArray:
    """Return what a walk of a triad's biases by 1 [g, deg/s] in an hour's root adds to every row (n, k).

    A column is a step in one sensor, before each step of the recording but the first, as large as its time allows;
    with ``parts`` also before each part of a dwell or rest, within which a walk makes slopes. Within a soak a walk
    has a name (`procedures.effects.bias_noise`).
    """
    seen, found = evidence.excitation, list[FloatArray]()
    history, soaks = seen.histories, np.array([step.kind == "soak" for step in seen.steps])
    for one in np.unique(history):
        here = history[seen.step] == one
        for earlier, later in pairwise(sorted(_places(seen, np.flatnonzero((history == one) & ~soaks), parts))):
            if later > earlier:
                after = here & (seen.t >= later)
                found.append(np.sqrt((later - earlier) / S_PER_H) * per_axis(after.astype(float)))
    if not found:
        return np.zeros((len(evidence.residual), 0))
    values = np.concatenate(found, axis=2)
    names = tuple(str(i) for i in range(values.shape[2]))
    is_accel = triad == "accelerometer"
    return evidence.column(Columns(names, accel=values) if is_accel else Columns(names, gyro=values))


def _places(seen: Excitation, steps: np.ndarray, parts: int) -> Iterator[float]:
    """Yield the times [s] before which a walk steps: at the beginnings of ``steps``, and in rests."""
    for number in steps:
        t = seen.t[seen.step == number]
        if len(t):
            first, last = float(np.min(t)), float(np.max(t))
            several = parts if seen.steps[number].kind in RESTING else 1
            yield from (first + part / several * (last - first) for part in range(several))


SAME_ATTITUDE = 0.1  # of the elements of two rotation matrices, six degrees: placements scatter by less
Options = list[tuple[float, FloatArray, str]]  # share of the prior, whitened columns (n, k), what it is
# What drives a function, by its coordinate: what an effect of the catalogue names as its ``driver``.
DRIVERS = {
    "time": "time", "time times the output": "time", "a temperature that was not recorded": "time",
    "temperature": "temperature",
    "temperature times the output": "temperature", "specific force": "input", "the input at rest": "input",
    "the rate": "input", "the time at rest and before": "time at rest",
}  # fmt: skip
Way = tuple[str, list[FloatArray], list[float]]  # what it is, values (n,) or (n, 3) at the nodes, their 1 sigma


class Function(NamedTuple):
    """A function without a name: its options, and what drives it in its triad, "" where no effect shares that."""

    options: Options
    driver: str = ""


def functions(evidence: Evidence) -> dict[str, Function]:
    """Return by name every function without a name."""
    return {f"a function of {name}": found for name, found in _by_name(evidence, _coordinates).items()}


def unrecorded(evidence: Evidence) -> dict[str, Function]:
    """Return by name what is known to change and was not recorded: the temperature, where there is none."""
    return _by_name(evidence, _unrecorded)


def driver_in(triad: str, driver: str) -> str:
    """Return a driver as it acts in one triad, "" where nothing is known to drive it."""
    return driver and f"{driver}, {triad}"


def _by_name(evidence: Evidence, coordinates: Callable[..., dict[str, list[Way]]]) -> dict[str, Function]:
    found, seen = dict[str, Function](), evidence.excitation
    for number, triad in enumerate(TRIADS):
        if not (
            evidence.rows("mean", "slope", "turn", "norm", "rate", "soak", "move") & (evidence.triad == number)
        ).any():
            continue
        output = np.nan_to_num((seen.accel_output, seen.gyro_output)[number])
        for coordinate, ways in coordinates(seen, output, triad).items():
            if options := _options(evidence, number, ways):
                driver = driver_in(triad, DRIVERS.get(coordinate, ""))
                found[f"{coordinate}, {triad}"] = Function(options, driver)
    return found


def walk(evidence: Evidence, triad: str) -> Function:
    """Return a random walk of a triad's biases, of all sensors or of one."""
    H = walk_columns(evidence, triad, PARTS) / evidence.sigma[:, None]
    every = -(-H.shape[1] // (3 * MOST_DRAWS))  # of a long recording a coarser walk, of the same variance
    H = H.reshape(len(H), -1, 3)[:, ::every].reshape(len(H), -1) * np.sqrt(every) if every > 1 else H
    return Function(_of_sensors([H[:, i::3] for i in range(3)], "walk") if H.shape[1] else [])


def _options(evidence: Evidence, triad: int, ways: list[Way]) -> Options:
    found, rows = Options(), dict[int, list[FloatArray]]()
    for note, values, std in ways:
        if id(values) not in rows:  # several ways share their values
            rows[id(values)] = _rows(evidence, triad, values)
        found += _of_sensors([H * np.array(std) for H in rows[id(values)]], note)
    return found


def _rows(evidence: Evidence, triad: int, values: list[FloatArray]) -> list[FloatArray]:
    """Return for each sensor what values at its nodes make of every row (n, k), in sigmas."""
    nodes = len(evidence.excitation.t)
    V = np.nan_to_num(np.stack([np.broadcast_to(v.T, (3, nodes)) for v in values], axis=2))
    sums, found = _sums(evidence, triad), list[FloatArray]()
    for i, of_sensor in enumerate(sums[0]):
        H = np.asarray(of_sensor @ V[i], np.float64)
        for each in sums[1]:
            H[each.rows] += each.mix[:, [i]] * (each.w @ V[i][each.nodes])
        for stepped in evidence.stepped:
            stepped.free(H)
        found.append(H / evidence.sigma[:, None])
    return found


@lru_cache(maxsize=4)
def _sums(evidence: Evidence, triad: int) -> tuple[list[Any], list[Any]]:
    sums = row_sums(evidence.weights, triad, len(evidence.residual), len(evidence.excitation.t))
    by_column = sums.of_sensors.tocsc()
    return [by_column[:, i::3].tocsr() for i in range(3)], [each for each in sums.mixed if each.mix is not None]


def _of_sensors(parts: list[FloatArray], note: str) -> Options:
    """Return columns of all three sensors, and of each, in units of what they do to all rows together."""
    found: Options = []
    sets = [(float(len(parts)), np.hstack(parts), note)]
    sets += [(1.0, part, f"{note}, in {axis}") for part, axis in zip(parts, AXES, strict=True)]
    for share, H, what in sets:
        size = float(np.linalg.norm(H))
        if size > 0:
            found.append((share, H / size, what))
    return found


BENT = dict(zip(priors.BENDS, ("a smooth curve", "a curve with many bends"), strict=True))


def waves(x: FloatArray, by: FloatArray | float = 1.0) -> list[Way]:
    """Return a smooth function of x (n,) or (n, 3) in [0, 1] at each bend, times ``by``."""
    k = np.arange(1, priors.HALF_PERIODS + 1)
    values = [np.cos(np.pi * each * x) * by for each in k.tolist()]
    return [(BENT[bend], values, (1 / (1 + (k / bend) ** 2)).tolist()) for bend in priors.BENDS]


def _equal(note: str, values: list[FloatArray]) -> Way:
    """Return a way of values that are equally large."""
    return note, values, [1.0] * len(values)


def _unit(x: FloatArray) -> FloatArray:
    low, high = np.nanmin(x), np.nanmax(x)
    return (x - low) / max(float(high - low), 1e-12)


def _unrecorded(seen: Excitation, output: FloatArray, triad: str) -> dict[str, list[Way]]:
    """Return the temperature as a function of time, where time is known and temperature is not."""
    if np.isfinite(seen.temperature).any() or not np.isfinite(seen.t).all():
        return {}
    time = (time_in_history(seen) + 1) / 2
    return {"a temperature that was not recorded": [_equal("ramp", [time]), *waves(time)]}


def _coordinates(seen: Excitation, output: FloatArray, triad: str) -> dict[str, list[Way]]:
    """Return by the name of a coordinate every kind of function of it."""
    kind = np.array([step.kind for step in seen.steps])[seen.step]
    turning, resting = np.isin(kind, ("turn", "move", "rate")), np.isin(kind, ("dwell", "rest", "soak"))
    found, f, time = dict[str, list[Way]](), np.nan_to_num(seen.f), (time_in_history(seen) + 1) / 2
    T = seen.temperature
    is_timed = bool(np.isfinite(seen.t).all())  # a rate table may have no time
    if is_timed:
        if np.isfinite(T).any():
            found["time"] = waves(time)
        found["time times the output"] = waves(time[:, None], output)
    if np.isfinite(T).any() and np.nanmax(T) - np.nanmin(T) > REVERSAL_K:
        spread, x = max(float(np.nanstd(T)), 1e-9), np.nan_to_num(_unit(T))
        at = (T - np.nanmean(T)) / spread
        rate = np.nan_to_num(seen.temperature_rate)
        rate = rate / max(float(np.std(rate)), 1e-12)
        times = priors.TIMES_S if is_timed else ()
        past = [T, *(sensor_temperature(seen, tau) for tau in times)]
        steps = [a - b for a, b in pairwise(past)] + [past[-1] - np.nanmean(past[-1])]
        history = [each[:, None] / max(float(np.nanstd(each)), 1e-12) for each in steps]
        B = (
            seen.magnetic / max(float(np.nanstd(seen.magnetic)), 1e-12)
            if np.isfinite(seen.magnetic).any()
            else f[:, :0]
        )
        vectors = [each[:, [i]] for each in (f, B) for i in range(each.shape[1])]
        products = [at, rate, at * rate, at**2, rate**2]
        found["temperature"] = [
            *waves(x),
            _equal("lags of it", history),
            _equal("products", products),
        ]
        found["temperature times the output"] = [
            *waves(x[:, None], output), _equal("lags of it", [each * output for each in history])
        ]  # fmt: skip
        about = (T - REFERENCE_C) / spread  # the model takes what is constant, but no vector
        found["temperature and attitude"] = [
            _equal("temperature times a vector", [each * by[:, None] for by in (about, at) for each in vectors]),
            _equal("its rate times a vector", [each * rate[:, None] for each in vectors]),
        ]
    square = [f[:, i] * f[:, j] for i in range(3) for j in range(i, 3)]
    cubic = [f[:, i] * f[:, j] * f[:, k] for i in range(3) for j in range(i, 3) for k in range(j, 3)]
    around = [np.roll(f, shift, axis=1) for shift in (1, 2)]
    others = square if triad == "gyroscope" else [each**2 for each in around]  # a sensor's own are named
    found["specific force"] = [_equal("second order", others), _equal("second and third order", [*others, *cubic])]
    histories = seen.histories[seen.step]
    first = [resting & np.isnan(seen.change[:, 0]) & (histories == one) for one in np.unique(histories)]
    before = [np.nan_to_num(seen.f_before[:, i]) * resting for i in range(3)] + [1.0 * each for each in first]
    fading = [np.where(resting, np.exp(-seen.rest_s / tau), 0.0)[:, None] for tau in priors.TIMES_S]
    by = {"alone": np.ones_like(f[:, :1]), "by the change": np.nan_to_num(seen.change), "by f": f, "by f^2": f**2}
    found["the time at rest and before"] = [
        _equal("the position before", before),
        *(_equal(note, [each * value for each in fading]) for note, value in by.items()),
    ]
    if resting.any():
        found["the input at rest"] = _of_input(np.where(resting[:, None], output, np.nan))
    if seen.C_sn is not None and np.isfinite(seen.C_sn).any():
        east, north = (np.nan_to_num(seen.C_sn[:, :, i]) for i in range(2))
        second = [east, north, east * north, north**2, east**2]
        found["the heading"] = [_equal("once a turn", [east, north]), _equal("twice a turn", second)]
    if attitudes := _attitudes(seen, resting):
        found["the attitude"] = [_equal("one value for each attitude", attitudes)]
    if triad == "accelerometer" and np.isfinite(seen.magnetic).any():  # of a gyroscope it is named
        found["the magnetic field"] = [_equal("linear", [seen.magnetic[:, i] for i in range(3)])]
    if triad == "gyroscope" and turning.any():
        u = output / max(float(np.abs(output[turning]).max()), 1e-12)
        around = [np.where(turning[:, None], np.roll(u, s, axis=1), 0.0) for s in (1, 2)]
        found["the rate"] = _of_input(np.where(turning[:, None], output, np.nan))
        found["the other axes' rates"] = [
            _equal("even and odd part", [g for v in around for g in (v**2, v * np.abs(v))])
        ]
        if is_timed:
            warmth = [warmth_of_turning(seen, turning, tau) for tau in priors.TIMES_S]
            warmth = [each / max(float(np.max(np.abs(each))), 1e-300) for each in warmth]
            found["the warmth of turning"] = [_equal("fading", warmth)]
    return found


def _attitudes(seen: Excitation, resting: BoolArray) -> list[FloatArray]:
    """Return which nodes (n,) rest at each attitude, where these are not too many."""
    known = resting if seen.C_sn is None else resting & np.isfinite(seen.C_sn).all(axis=(1, 2))
    if seen.C_sn is None or not known.any():
        return []
    steps = np.unique(seen.step[known])
    of_steps = [seen.C_sn[known & (seen.step == step)][0] for step in steps]
    kinds, found = list[FloatArray](), list[FloatArray]()
    for step, C in zip(steps, of_steps, strict=True):
        rests = 1.0 * (known & (seen.step == step))
        same = [i for i, other in enumerate(kinds) if np.max(np.abs(C - other)) < SAME_ATTITUDE]
        if same:
            found[same[0]] += rests
        else:
            kinds.append(C)
            found.append(rests)
    return found if len(kinds) <= MOST_DRAWS else []


def _of_input(u: FloatArray) -> list[Way]:
    """Return functions of a sensor's own input u (n, 3), nan where there is none: waves, zones, a range's end."""
    size, known = max(float(np.nanmax(np.abs(u))), 1e-12), np.isfinite(u)
    x, median = np.nan_to_num(u / size), max(float(np.median(np.abs(u[known]))), 1e-12)
    found = waves(np.where(known, (x + 1) / 2, 0.0), 1.0 * known)
    for width in (priors.KNEES[0] * median / size, median / size, priors.KNEES[0]):
        near = np.where(known, np.exp(-0.5 * (x / width) ** 2), 0.0)
        found.append(_equal(f"within {100 * width:.2g} % of the range about zero", [near, near * x / width]))
    knees = [np.sign(x) * np.maximum(np.abs(x) - knee, 0.0) for knee in priors.KNEES]
    return [*found, _equal("end of the range", knees)]


def warmth_of_turning(seen: Excitation, turning: BoolArray, tau_s: float) -> FloatArray:
    """Return what turning has warmed (n,), which follows the square of the rate, of any unit."""
    power, history = np.where(turning, np.sum(seen.omega**2, axis=1), 0.0), seen.histories[seen.step]
    found = np.zeros(len(seen.t))
    for one in np.unique(history):
        order = np.flatnonzero(history == one)
        order = order[np.argsort(seen.t[order], kind="stable")]
        found[order] = lagged(seen.t[order], power[order], tau_s)
    return found


def time_in_history(seen: Excitation) -> FloatArray:
    """Return time (n,) from -1 to 1 within each history."""
    history, x = seen.histories[seen.step], np.zeros(len(seen.t))
    for one in np.unique(history):
        here = history == one
        t = seen.t[here]
        x[here] = 2 * (t - t.min()) / max(float(np.ptp(t)), 1e-9) - 1
    return x
