"""Every law of `laws` as a term: what it adds at the nodes is what plain numpy makes of it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from procedures.effects.excitation import Excitation, ExcitationStep
from procedures.effects.temperature_history import sensor_temperature
from procedures.effects.term.effect_of_term import TermEffect
from procedures.effects.term.grammar import parse
from procedures.effects.term.latex import latex
from procedures.effects.term.law import Parameter
from tests.procedures.effects.terms.laws import LAWS, Law, Seen

NODES = 40
KINDS = ("dwell", "turn")


def drawn(seed: int) -> Seen:
    """A campaign of two steps: whatever the sensors may feel, in plain units."""
    rng = np.random.default_rng(seed)
    t = np.sort(rng.uniform(500.0, 503.0, NODES))
    begin = np.where(np.arange(NODES) < NODES // 2, t[0], t[NODES // 2]) - 0.05
    axes = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    n = (NODES, 3)
    return Seen(
        f=rng.uniform(-1, 1, n), w=rng.uniform(-90, 90, n) * rng.choice([1, 1e-4], n), B=rng.uniform(-50, 50, n),
        T=rng.uniform(10, 40, NODES), T_per_s=rng.uniform(-0.01, 0.01, NODES), t=t, t_step=t - begin,
        before=rng.uniform(-1, 1, n), north=np.tile(axes[0], (NODES, 1)), east=np.tile(axes[1], (NODES, 1)),
        aux=rng.uniform(0, 5, NODES),
    )  # fmt: skip


def excitation(s: Seen) -> Excitation:
    steps = tuple(ExcitationStep(kind, kind, 0, 0, "") for kind in KINDS)
    unit = np.tile(np.eye(3), (NODES, 1, 1))
    C_sn = np.stack((s.east, s.north, np.cross(s.east, s.north)), axis=2)
    return Excitation(
        f=s.f, omega=s.w, magnetic=s.B, accel_output=s.f + 1e-3, gyro_output=s.w + 1e-3, change=s.f - s.before,
        t=s.t, rest_s=s.t_step, temperature=s.T, temperature_rate=60 * s.T_per_s, auxiliary={"heater": s.aux},
        step=np.arange(NODES) // (NODES // 2), C_sb=unit, E_accel=unit, E_gyro=unit, steps=steps, C_sn=C_sn,
    )  # fmt: skip


def term_of(law: Law) -> TermEffect:
    terms = (law.term,) if isinstance(law.term, str) else law.term
    shape = {name: Parameter(*one) for name, one in law.shape.items()}
    return TermEffect(law.name, law.triad, terms, law.unit, law.plausible, law.source, shape)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_a_law_as_a_term_adds_what_plain_numpy_says(law: Law) -> None:
    for seed in range(3):
        s = drawn(seed)
        # the time operators of plain numpy step through milliseconds: their constants are as short as the campaign
        at = {**law.at, **({"tau": 0.7} if law.name in {"self_heating", "heater_behind"} else {})}
        expected = law.truth(s, **at)
        found = term_of(law).values(excitation(s), at)
        assert found.shape == (NODES, 3, 1 if isinstance(law.term, str) else len(law.term))
        scale = np.abs(expected).max()
        loose = 2e-3 if law.name in {"self_heating", "heater_behind"} else 1e-10
        assert scale > 0
        assert np.abs(found - expected.reshape(found.shape)).max() < loose * scale


def test_columns_are_each_sensors_own() -> None:
    law = next(law for law in LAWS if law.name == "anisoelastic")
    seen = excitation(drawn(1))
    (way,) = term_of(law).columns(seen)
    assert way.coefficients == ("x.1", "x.2", "y.1", "y.2", "z.1", "z.2")
    assert way.gyro is not None
    truth = law.truth(drawn(1))
    for sensor in range(3):
        assert np.allclose(way.gyro[:, sensor, 2 * sensor : 2 * sensor + 2], truth[:, sensor])
        assert not np.delete(way.gyro[:, sensor], (2 * sensor, 2 * sensor + 1), axis=1).any()


def test_a_lag_of_the_temperature_is_the_catalogues_own() -> None:
    seen = excitation(drawn(2))
    term = TermEffect("lag", "gyroscope", ("lag(T, tau)",), "deg/h/K", 1.0, "", {"tau": Parameter("s", 1, 100)})
    expected = (sensor_temperature(seen, 30.0) - 25) / 3600
    assert np.allclose(term.values(seen, {"tau": 30.0})[:, 0, 0], expected, rtol=1e-12)
    assert not term.looks_back


SLOPE = 0.01  # K/s


def ramp_lagged(t: np.ndarray, *tau: float) -> np.ndarray:
    """What follows ``SLOPE t``, from equilibrium at 0, through one lag or two: the response to a ramp."""
    a, b = tau[0], tau[-1]
    if len(tau) == 1:
        return SLOPE * (t - a * (1 - np.exp(-t / a)))
    if a == b:
        return SLOPE * (t - 2 * a + (2 * a + t) * np.exp(-t / a))
    return SLOPE * (t - a - b + (a**2 * np.exp(-t / a) - b**2 * np.exp(-t / b)) / (a - b))


SWITCHED_ON = (
    ("lag(T, 400 [s])", lambda t: ramp_lagged(t, 400.0)),
    ("lag(T - 5 [K], 400 [s])", lambda t: ramp_lagged(t, 400.0) - 5),
    ("lag(2 * T, 400 [s])", lambda t: 2 * ramp_lagged(t, 400.0)),
    ("lag(-T * pi / k, 400 [s])", lambda t: -ramp_lagged(t, 400.0) * np.pi / 3),
    ("lag((T - 5 [K]) / (2 * k), 400 [s])", lambda t: (ramp_lagged(t, 400.0) - 5) / 6),
    ("lag(T + f_norm * 0 [K/g], 400 [s])", lambda t: ramp_lagged(t, 400.0)),
    ("lag(lag(T, 100 [s]), 400 [s])", lambda t: ramp_lagged(t, 100.0, 400.0)),
    ("lag(lag(2 * T - 5 [K], 400 [s]), 100 [s])", lambda t: 2 * ramp_lagged(t, 400.0, 100.0) - 5),
    ("lag(lag(T, 400 [s]), 400 [s])", lambda t: ramp_lagged(t, 400.0, 400.0)),
    ("lag(lag(T, 399.9 [s]), 400 [s])", lambda t: ramp_lagged(t, 399.9, 400.0)),
    ("lag(lag(T, 100 [s]) - T, 400 [s])", lambda t: ramp_lagged(t, 100.0, 400.0) - ramp_lagged(t, 400.0)),
)  # fmt: skip


@pytest.mark.parametrize(("text", "truth"), SWITCHED_ON, ids=[text for text, _ in SWITCHED_ON])
def test_a_lag_of_what_is_linear_in_the_temperature_knows_the_time_since_power_on(
    text: str, truth: Callable[[np.ndarray], np.ndarray]
) -> None:
    s = drawn(2)
    t = 60.0 + s.t - s.t[0]  # begun a minute after power-on, which the sensor remembers
    warm = replace(s, t=t, T=25 + SLOPE * t, T_per_s=np.full(NODES, SLOPE))
    shape = {"k": Parameter("1", 1, 10)} if "k" in text else {}
    term = TermEffect("lag", "gyroscope", (text,), "deg/h/K", 1.0, "", shape)
    found = 3600 * term.values(excitation(warm), {"k": 3.0} if shape else {})[:, 0, 0]
    assert np.abs(found - truth(t)).max() < 2e-6 * SLOPE * 60


# Terms in the field's notation


WRITTEN = (
    ("T * T_rate", r"T\,\dot T"),
    ("f_2**2", r"f_{i+1}^{2}"),
    ("u * exp(-(u / w)**4)", r"\omega_i\,\exp\left(- \left(\frac{\omega_i}{w}\right)^{4}\right)"),
    ("lag(omega_norm**2, tau)", r"\mathrm{lag}_{\tau}\left(\lVert \omega \rVert^{2}\right)"),
    ("(f - f_before) * log(1 + t_step / 3 [s])",
     r"\left(f_i - f_i^{-}\right)\,\ln\left(1 + \frac{t_\mathrm{s}}{3\,\mathrm{s}}\right)"),
    ("sign(u) * max(0, abs(u) - w)",
     r"\operatorname{sgn}\left(\omega_i\right)\,\max\left(0, \lvert \omega_i \rvert - w\right)"),
    ("aux_fan * (T - (t - t_step) * B_x)",
     r"\mathrm{aux\_fan}\,\left(T - \left(t - t_\mathrm{s}\right)\,B_x\right)"),
    ("'aux_fan-speed 2 #%' * T", r"\mathrm{aux\_fan-speed\ 2\ \#\%}\,T"),
)  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), WRITTEN, ids=[text for text, _ in WRITTEN])
def test_a_term_is_written_as_the_field_writes_it(text: str, expected: str) -> None:
    assert latex(parse(text), "gyroscope") == expected
