"""What stands beside the results of a digital certificate: each part where there is something to say."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from station.results.certificate.as_found import AsFound, Shift
from station.results.certificate.dcc.effects_and_global_test import effects_and_global_test
from tests.station.results.certificate.dcc_numbers import NS, of_type

SHIFT = Shift("gyroscope.bias.x", "deg/h", 1.5, -0.25, 0.125)
BEFORE = AsFound("ab" * 32, "2026-03-04T12:00:00Z", "calibrated", "PASS", "PASS", (SHIFT,))
EFFECT = {"name": "own.odd", "unit": "deg/h", "coefficients": {"c": {"value": 0.5, "std": 0.25}}}


def parts(before: AsFound | None = None, **document: Any) -> list[Any]:
    said: Any = SimpleNamespace(document=document, before=before)
    return list(effects_and_global_test(said))


def numbers_of(element: Any, *paths: str) -> list[str | None]:
    return [element.findtext(f".//si:{path}", None, NS) for path in paths]


@pytest.mark.parametrize(
    ("said", "found"),
    [
        ({}, []),
        ({"residual": {}, "effects": ()}, []),
        ({"residual": {"chi2_of_others": 1.0}}, []),
        ({"before": replace(BEFORE, shifts=())}, []),
        ({"residual": {"dof": 27}}, ["fog_globalTest"]),
        ({"effects": (EFFECT,)}, ["fog_effects"]),
        ({"before": BEFORE}, ["fog_asFound"]),
        (
            {"residual": {"dof": 27}, "effects": (EFFECT,), "before": BEFORE},
            ["fog_globalTest", "fog_effects", "fog_asFound"],
        ),
    ],
)
def test_each_part_is_there_where_something_is_known_of_it(said: dict[str, Any], found: list[str]) -> None:
    assert [one.find("dcc:data", NS).getparent().get("refType") for one in parts(**said)] == found


def test_the_global_test_has_each_number_that_is_known_in_order() -> None:
    (made,) = parts(residual={"p_value": 0.254, "dof": 27, "chi2": 31.4})
    found = [
        (one.get("refType"), *numbers_of(one, "value", "unit")) for one in made.iter(f"{{{NS['dcc']}}}quantity")
    ]
    assert found == [
        ("fog_chi2", "31.4", r"\one"), ("fog_dof", "27.0", r"\one"), ("fog_p_value", "0.254", r"\one"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("coefficient", "said"),
    [
        ({"value": 0.5, "std": 0.25}, ["0.5", r"\degree\hour\tothe{-1}", "own.odd.c", "0.25", "1.0"]),
        ({"value": 0.5}, ["0.5", r"\degree\hour\tothe{-1}", "own.odd.c", None, None]),
        ({"value": 0.5, "std": 0.0}, ["0.5", r"\degree\hour\tothe{-1}", "own.odd.c", "0.0", "1.0"]),
    ],
)
def test_a_coefficient_has_its_sigma_where_it_has_one(coefficient: dict[str, float], said: list[str]) -> None:
    (made,) = parts(effects=({**EFFECT, "coefficients": {"c": coefficient}},))
    assert numbers_of(made, "value", "unit", "label", "uncertainty", "coverageFactor") == said


@pytest.mark.parametrize(
    ("coefficient", "said"),
    [({"value": 0.5, "std": 0.25}, "0.5 (furlong), 1 sigma 0.25"), ({"value": 0.5}, "0.5 (furlong)")],
)
def test_a_coefficient_in_a_unit_of_ones_own_is_written_out(coefficient: dict[str, float], said: str) -> None:
    (made,) = parts(effects=({**EFFECT, "unit": "furlong", "coefficients": {"c": coefficient}},))
    assert made.findtext(".//dcc:noQuantity/dcc:content", None, NS) == said


def test_a_coefficients_own_unit_goes_before_that_of_the_effect() -> None:
    both = {"c": {"value": 0.5}, "tau": {"value": 40.0}}
    (made,) = parts(effects=({**EFFECT, "units": {"tau": "s"}, "coefficients": both},))
    units = [one.text for one in made.iter(f"{{{NS['si']}}}unit")]
    assert units == [r"\degree\hour\tothe{-1}", r"\second"]


def test_an_effect_of_ones_own_has_the_hash_of_its_definition_and_one_without_coefficients_says_so() -> None:
    (made,) = parts(effects=({**EFFECT, "sha256": "ef" * 32}, {**EFFECT, "name": "own.even", "coefficients": {}}))
    odd, even = of_type(made, "fog_own.odd", "list") + of_type(made, "fog_own.even", "list")
    (stated,) = of_type(made, "fog_effectHash", "quantity")
    assert stated.findtext("dcc:noQuantity/dcc:content", None, NS) == "ef" * 32
    assert stated.getparent() is odd
    texts = [one.text for one in even.iterfind("dcc:quantity/dcc:noQuantity/dcc:content", NS)]
    assert texts == ["no coefficients", "keine Koeffizienten"]


def test_a_shift_has_what_was_applied_the_error_with_its_u_and_how_many_sigmas_that_is() -> None:
    (made,) = parts(BEFORE)
    (shift,) = of_type(made, "fog_shift", "list")
    assert shift.get("refId") == "gyroscope.bias.x"
    found = {
        one.get("refType"): numbers_of(one, "value", "uncertainty", "coverageFactor")
        for one in shift.iterfind("dcc:quantity", NS)
    }
    assert found == {
        "fog_appliedBefore": ["1.5", None, None],
        "basic_measurementError": ["-0.25", "0.125", "2.0"],
        "fog_errorOverStandardUncertainty": [found["fog_errorOverStandardUncertainty"][0], None, None],
    }
    assert abs(float(found["fog_errorOverStandardUncertainty"][0] or 0)) == 4.0
