"""Effects written as terms, planted: they add what plain numpy says, and a solve finds what was planted."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.errors import TruthRefused
from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.effects import Stimulus, TriadInput, planted
from drivers.simulated.truth import Truth, load_truth
from procedures.campaign.plan_steps import turn_steps
from procedures.diagnosis.declared_effects import solve_declared
from procedures.effects.term.effect_of_term import TermEffect
from procedures.effects.term.law import Parameter
from tests.procedures.effects.terms.laws import LAWS, Law, Seen
from tests.procedures.effects.terms.test_laws import drawn

UNKNOWN = {
    "hinge_memory",
    "self_heating",
    "glue_creep",
    "heater_behind",
    "of_the_heading",
}  # of more than a moment
KNOWN = [law for law in LAWS if law.name not in UNKNOWN]
BIAS = {"accelerometer": np.full(3, 1e-3), "gyroscope": np.full(3, 2e-4)}


def text_of(law: Law) -> str:
    terms = [law.term] if isinstance(law.term, str) else list(law.term)
    lines = [
        'format = "effect/1"', f'name = "{law.name}"', f'triad = "{law.triad}"', f"term = {terms!r}",
        f'unit = "{law.unit}"', "plausible = 1.0", 'source = "x"',
    ]  # fmt: skip
    lines += [f'shape.{k} = {{unit = "{u}", low = {a}, high = {b}}}' for k, (u, a, b) in law.shape.items()]
    return "\n".join(lines)


def stimulus(s: Seen) -> Stimulus:
    one = (s.t, s.t_step, s.T, 60 * s.T_per_s)
    t, rest, T, rate = (value[:, None] for value in one)
    return Stimulus(s.f, s.w, s.B, t, rest, T, rate, 1, lambda at: np.interp(at, s.t, s.T))


@pytest.mark.parametrize("law", KNOWN, ids=lambda law: law.name)
def test_a_planted_term_adds_what_plain_numpy_says(law: Law) -> None:
    name, s = f"{law.triad}.{law.name}", drawn(4)
    k = 1 if isinstance(law.term, str) else len(law.term)
    c = np.random.default_rng(3).uniform(-2, 2, (3, k))
    keys = [axis if k == 1 else f"{axis}.{j + 1}" for axis in "xyz" for j in range(k)]
    sizes = dict(zip(keys, c.ravel().tolist(), strict=True)) | law.at
    ((effect, given),) = planted({name: sizes}, {name: text_of(law)})
    of = TriadInput(s.f if law.triad == "accelerometer" else s.w, BIAS[law.triad])
    add = effect.accel if law.triad == "accelerometer" else effect.gyro
    assert add is not None
    expected = np.einsum("nik,ik->ni", law.truth(s, **law.at).reshape(len(s.t), 3, k), c)
    found = add(stimulus(s), of, given)
    assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("name", sorted(UNKNOWN))
def test_what_a_moment_does_not_determine_is_refused(name: str) -> None:
    law = next(law for law in LAWS if law.name == name)
    with pytest.raises(TruthRefused):
        planted({}, {f"{law.triad}.{law.name}": text_of(law)})


def test_a_time_constant_comes_back_from_a_planted_one() -> None:
    law = next(law for law in LAWS if law.name == "bias_warm_up")
    name = f"gyroscope.{law.name}"
    truth = replace(
        Truth.example(3), sample_period_s=0.05, effects={name: {"x": 8.0, "y": -5.0, "z": 6.0, "tau": 300.0}},
        terms={name: text_of(law)},
    )  # fmt: skip
    campaign = simulate_campaign(truth, 2, dwell_s=40.0, turns=turn_steps(1, 3.0), move_s=20.0)
    shape = {key: Parameter(*one) for key, one in law.shape.items()}
    term = TermEffect(law.name, law.triad, (str(law.term),), law.unit, 5.0, law.source, shape)
    (effect,) = solve_declared([campaign], [term]).effects
    assert effect.coefficients == ("x", "y", "z", "tau")
    assert np.all(np.abs(effect.value - [8.0, -5.0, 6.0, 300.0]) < 4 * effect.std)
    assert effect.std[3] < 60


def test_a_truth_is_read_with_its_terms() -> None:
    text = text_of(LAWS[0])
    truth = load_truth(
        f"[effects.\"gyroscope.dead_zone\"]\nx = 1\n[terms]\n\"gyroscope.dead_zone\" = '''\n{text}'''\n"
    )
    ((effect, given),) = planted(truth.effects, truth.terms)
    assert effect.name == "gyroscope.dead_zone"
    assert given == {"x": 1.0, "w": 10.0}


REFUSED = (
    ("-u * exp(-(u / w)**4)", "__import__(1)", "__import__"),
    ("-u * exp(-(u / w)**4)", "(lambda: 1)()", "moment"),
    ("-u * exp(-(u / w)**4)", "u.real", "moment"),
    ("-u * exp(-(u / w)**4)", "u if u else w", "moment"),
    ("-u * exp(-(u / w)**4)", "u +", "effect/1"),
    ('unit = "1"', 'unit = "__import__(1)"', "effect/1"),
    ('name = "dead_zone"', 'name = "other"', "that of gyroscope.dead_zone"),
    ("format", "format = [", "effect/1"),
)


@pytest.mark.parametrize(("old", "new", "reported"), REFUSED)
def test_what_is_no_effect_is_refused(old: str, new: str, reported: str) -> None:
    with pytest.raises(TruthRefused, match=reported):
        planted({}, {"gyroscope.dead_zone": text_of(LAWS[0]).replace(old, new)})


NO_NUMBERS = (
    "u*10**400", "u*1/0", "u*(-4)**0.5", "abs(u, 1)", "u*1e999", "u*1 [(h**12)**12]", "u*1 [1/(ppm**12)**12]",
    "u*log(0)",
)  # fmt: skip


@pytest.mark.parametrize("term", NO_NUMBERS)
def test_a_term_that_is_finite_nowhere_is_refused_at_once(term: str) -> None:
    law = replace(LAWS[0], term=term, shape={})
    with pytest.raises(TruthRefused, match=r"gyroscope\.dead_zone"):
        planted({}, {"gyroscope.dead_zone": text_of(law)})
