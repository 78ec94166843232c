from functools import cache

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Finding
from tests.benchmarks.diagnosing.designs import certified, plain, unit

K2 = {"accelerometer.quadratic": {"x": 4e-5}}  # 27 sigma under the certificate


@cache
def quadratic(is_certified: bool) -> Finding:
    make = certified if is_certified else plain
    findings = diagnose(make(unit(7, effects=K2), 7)).findings
    return next(f for f in findings if "accelerometer.quadratic" in (f.effect, *f.aliases))


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
