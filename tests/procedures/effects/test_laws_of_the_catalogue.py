"""Every law of the catalogue: its columns against plain numpy, its units, and how it is written."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.effects.excitation import KNEE, PERIOD, PLAY, TAU, Columns, Excitation, ExcitationStep
from procedures.effects.term.dimensions import COEFFICIENT, Dimensions
from procedures.effects.term.latex import latex_of_law
from procedures.effects.term.law import OUTPUT_UNITS, Law
from procedures.effects.term.units import Unit, parse_unit
from tests.procedures.effects.laws_by_hand import BY_HAND, ORDER, Felt

KINDS = ("dwell", "turn", "dwell", "move", "rest", *("soak",) * 32)  # a soak in 32 blocks
NODES = 10  # of a step, 2 s each
LAWS = [(effect, law) for effect in EFFECTS for law in effect.laws]
each_law = pytest.mark.parametrize(("effect", "law"), LAWS, ids=[f"{e.name} {law.shape}" for e, law in LAWS])


def campaign() -> Excitation:
    """Steps of a unit that warms and cools, one of them a turn."""
    rng, n = np.random.default_rng(6), NODES * len(KINDS)
    t = 2.0 * np.arange(n) + 40.0
    T = 25 + 6 * np.sin(t / 40)
    unit = np.tile(np.eye(3), (n, 1, 1))
    change = rng.normal(0, 1, (n, 3))
    change[:NODES] = np.nan
    f, omega = rng.uniform(-2, 2, (n, 3)), rng.uniform(-100, 100, (n, 3))
    gyro_output = omega + 1e-3
    gyro_output[:, 1] = 0.5  # a sensor whose input stands
    return Excitation(
        f=f, omega=omega, magnetic=rng.normal(0, 40, (n, 3)), accel_output=f + 1e-3, gyro_output=gyro_output,
        change=change, t=t, rest_s=np.tile(2.0 * np.arange(NODES) + 1, len(KINDS)), temperature=T,
        temperature_rate=9 * np.cos(t / 40), auxiliary={}, step=np.arange(n) // NODES, C_sb=unit, E_accel=unit,
        E_gyro=unit, steps=tuple(ExcitationStep(f"{i}", kind, 0, 0, "") for i, kind in enumerate(KINDS)),
        vibration=rng.uniform(0, 1, (n, 3)),
    )  # fmt: skip


def felt(seen: Excitation, way: Columns, triad: str) -> Felt:
    """The same, with what it has in addition to its coefficients."""
    u, out = (seen.f, seen.accel_output) if triad == "accelerometer" else (seen.omega, seen.gyro_output)
    rests = np.isin(np.array(KINDS)[seen.step], ("dwell", "rest"))
    tau, width, T = way.nonlinear.get(TAU, 1.0), way.nonlinear.get(PLAY, 1.0), seen.temperature - 25
    rate = 9 * np.cos(seen.t / 40)
    return Felt(
        u, out, seen.f, seen.magnetic, T, rate, followed(seen, tau), np.array(directions(T.tolist())),
        played(T, width, float(T[0] - rate[0] * seen.t[0] / 60)), seen.t, seen.t - 39.0,
        np.where(rests, seen.rest_s, np.nan), seen.change, seen.vibration, tau, way.nonlinear.get(KNEE, 0.0),
        way.nonlinear.get(PERIOD, 1.0),
    )  # fmt: skip


def followed(seen: Excitation, tau: float) -> FloatArray:
    """A first-order lag by steps of a hundredth, from 25 degC and the first slope back to t = 0."""
    T = seen.temperature - 25
    rate = float(seen.temperature_rate[0]) / 60
    past = T[0] - rate * seen.t[0] if seen.t[0] < tau else T[0]
    t, warm = (np.concatenate(([0.0], seen.t)), np.concatenate(([past], T))) if seen.t[0] < tau else (seen.t, T)
    found, at = [warm[0]], float(warm[0])
    for i in range(1, len(t)):
        fine = np.linspace(t[i - 1], t[i], 101)
        ramp = np.interp(fine, t[i - 1 : i + 1], warm[i - 1 : i + 1])
        for now, step in zip((ramp[1:] + ramp[:-1]) / 2, np.diff(fine), strict=True):
            at += (now - at) * (1 - np.exp(-step / tau))
        found.append(at)
    return np.array(found[-len(T) :])


def directions(T: list[float]) -> list[float]:
    """1 between a trough and the next crest, -1 between a crest and the next trough."""
    return [float(np.sign(T[min(i + 1, len(T) - 1)] - T[min(i, len(T) - 2)])) for i in range(len(T))]


def played(T: FloatArray, width: float, at: float) -> FloatArray:
    left = []
    for now in T:
        at = now - width if now - at > width else now + width if at - now > width else at
        left.append((now - at) / width)
    return np.array(left)


@each_law
def test_columns_are_what_plain_numpy_says(effect: Effect, law: Law) -> None:
    if (effect.name, law.shape) not in BY_HAND:
        pytest.skip("planted alone: test_every_effect.py")
    seen, number = campaign(), 0
    triad = effect.name.partition(".")[0]
    for way in effect.columns(seen):
        if way.shape != law.shape or max(way.orders, default=1) > ORDER:
            continue
        number += 1
        value = BY_HAND[effect.name, law.shape](felt(seen, way, triad))[:, :, : max(way.orders, default=ORDER)]
        n, _, terms = value.shape
        expected = (np.eye(3)[None, :, :, None] * value[:, :, None, :]).reshape(n, 3, 3 * terms)
        found = way.accel if triad == "accelerometer" else way.gyro
        assert found is not None
        assert (way.gyro if triad == "accelerometer" else way.accel) is None
        keys = way.coefficients[: 3 * terms]
        assert [key[0] for key in keys] == [axis for axis in "xyz" for _ in range(terms)]
        assert not found[:, :, 3 * terms :].any()  # what is not linear, of which nothing is known yet
        close = 2e-5 if "lag" in effect.name else 1e-12  # a lag by hand is of finite steps
        off = np.abs(found[:, :, : 3 * terms] - expected).max(axis=(0, 1))
        assert np.all(off <= close * np.abs(expected).max(axis=(0, 1)))
        assert np.abs(expected).any()
    assert number


@each_law
def test_the_units_of_a_law_make_the_output_of_its_triad(effect: Effect, law: Law) -> None:
    powers = {name: parse_unit(one.unit).powers for name, one in law.parameters.items()}
    powers |= {COEFFICIENT: parse_unit(law.unit).powers} if law.is_inside else {}
    for n, text in enumerate(law.written(ORDER)):
        of_term = Dimensions(text, law.triad, powers, is_of_catalogue=True).of(law.nodes(ORDER)[n])
        assert of_term is not None
        unit = "1" if law.is_inside else f"{law.unit}/K^{n}" if law.is_polynomial else law.unit
        assert (Unit(1.0, of_term) * parse_unit(unit)).powers == parse_unit(OUTPUT_UNITS[law.triad]).powers


@each_law
def test_a_law_is_written_with_every_name_in_it(effect: Effect, law: Law) -> None:
    assert latex_of_law(law).count("{") == latex_of_law(law).count("}")
    assert all(name in law.equation for name in (*law.inputs, *law.parameters))


def test_laws_as_the_field_writes_them() -> None:
    written = {(effect.name, law.shape): latex_of_law(law) for effect, law in LAWS}
    assert written["accelerometer.quadratic", ""] == r"c\,f_i^{2}"
    assert written["gyroscope.g_sensitivity", ""] == r"c_{1}\,f_x + c_{2}\,f_y + c_{3}\,f_z"
    lagged = r"\mathrm{lag}_{\tau}\left(T\right)"
    assert written["gyroscope.temperature_lag", ""] == rf"c_{{1}}\,{lagged} + c_{{2}}\,{lagged}^{{2}} + \dots"
