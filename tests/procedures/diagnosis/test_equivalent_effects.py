from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from procedures.diagnosis import equivalent_effects
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.equivalent_effects import are_aliases
from procedures.diagnosis.linear_model import fit_linear
from procedures.diagnosis.result import Finding
from tests.benchmarks.diagnosing.designs import certified, plain, unit
from tests.procedures.diagnosis.redrawn import made_up, redrawn, seen_by, small

K2 = {"accelerometer.quadratic": {"x": 4e-5}}  # 27 sigma under the certificate


def two(rng: np.random.Generator, angle: float, size: float = 100.0) -> tuple[Candidate, Candidate]:
    """Return a term and one that makes ``angle`` [rad] with it."""
    base = small(rng)
    Q = np.linalg.qr(np.hstack((base.A, rng.standard_normal((36, 2)))))[0][:, -2:]
    one, other = Q[:, :1], np.cos(angle) * Q[:, :1] + np.sin(angle) * Q[:, 1:]
    return made_up(base, one), made_up(base, other, "fixture.made_up", size)


def test_a_term_in_the_same_direction_takes_the_place() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        base = small(rng)
        one, other = two(rng, 0.0)
        new = redrawn(base, rng, 8 * one.term.H[:, 0])
        assert are_aliases(new, one.fit(new), [other.term])[0]


def test_an_orthogonal_term_does_not() -> None:
    rng = np.random.default_rng(2)
    base = small(rng)
    one, other = two(rng, np.pi / 2)
    new = redrawn(base, rng, 8 * one.term.H[:, 0])
    assert not are_aliases(new, one.fit(new), [other.term])[0]


def test_a_term_too_small_to_do_it_does_not() -> None:
    rng = np.random.default_rng(3)
    base = small(rng)
    one, other = two(rng, 0.0, size=0.3)  # of the same direction, but a third of a sigma at most is plausible
    new = redrawn(base, rng, 8 * one.term.H[:, 0])
    assert not are_aliases(new, one.fit(new), [other.term])[0]


@cache
def quadratic(is_certified: bool) -> Finding:
    make = certified if is_certified else plain
    findings = diagnose(make(unit(7, effects=K2), 7)).findings
    return next(f for f in findings if "accelerometer.quadratic" in (f.effect, *f.aliases))


def test_quadratic_and_faces_without_certificate_look_alike() -> None:
    _, evidence, pool = seen_by("plain")
    term, faces = pool["accelerometer.quadratic"][0].term, pool["fixture.parallelism"][0].taken
    ones = np.ones(len(evidence.sigma))
    beside = fit_linear(evidence, [term], factor=ones).coefficients()[1][0, 0]
    alone = fit_linear(evidence, [term], ~faces, ones).coefficients()[1][0, 0]
    assert np.sqrt(1 - alone / beside) > 0.997


def test_certified_quadratic_is_not_its_faces_though_they_look_alike() -> None:
    finding = quadratic(True)
    assert finding.effect == "accelerometer.quadratic"
    assert set(finding.aliases) <= {"accelerometer.scale_asymmetry"}
    assert abs(finding.value[0] / finding.std[0]) > 15
    assert abs(finding.value[0] - 4e-5) < 4 * finding.std[0]


def test_uncertified_quadratic_goes_by_the_name_of_its_faces() -> None:
    finding = quadratic(False)
    assert finding.kind == "bench"
    assert finding.confidence == "ambiguous"
    assert "accelerometer.quadratic" in finding.aliases
    assert finding.separate_by


def test_where_none_stands_by_itself_the_combination_that_another_widens_most_is_looked_at(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """In sigmas: 2.9 and 2.9, 4.1 together; 3.6 along 75 deg, of which another leaves nought,
    four times as wide.

    The best combination, at 45 deg, stands beside the other with 4.3 sigma: by itself it would tell nothing.
    """
    size, along = np.array([2.0, 1.0]), np.array([np.cos(np.radians(75)), np.sin(np.radians(75))])
    across = np.array([-along[1], along[0]])
    finding = SimpleNamespace(coefficients=lambda: (2.9 * size, np.diag(size**2)))
    wider = np.outer(size, size) * (np.eye(2) + 15 * np.outer(along, along))
    for left, is_alias in ((0.0, True), (15.0, False)):  # sigmas of the finding alone
        beside = [(size * (left * along - 30 * across), wider)]
        monkeypatch.setattr(equivalent_effects, "coefficients_beside", lambda *_: beside)  # noqa: B023
        assert are_aliases(None, finding, [None]) == [is_alias]  # type: ignore[arg-type, list-item]
