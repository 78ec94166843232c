r"""Units and uncertainties of the D-SI as laboratories write them; what is none is refused in a line."""

import math

import pytest
from lxml import etree

from station.results.fixtures.dsi_reading import NoQuantity, read_real, read_unit
from tests.refusals import refused
from tests.station.results.certificate.signing.small_dcc import real

ARCSEC = math.pi / 648000


@pytest.mark.parametrize(
    ("text", "factor", "kind"),
    [
        ("\\metre", 1.0, ("metre",)),
        ("\\milli\\metre", 1e-3, ("metre",)),
        ("\\milli\\metre\\tothe{2}", 1e-6, ("metre", "metre")),
        ("\\radian", 1.0, ("radian",)),
        ("\\micro\\radian", 1e-6, ("radian",)),
        ("\\arcsecond", ARCSEC, ("radian",)),
        ("\\arcminute", 60 * ARCSEC, ("radian",)),
        ("\\degree", math.pi / 180, ("radian",)),
        ("\\arcsecond\\tothe{2}", ARCSEC**2, ("radian", "radian")),
        ("\\micro\\metre\\per\\metre", 1e-6, ()),
        ("\\micro\\metre\\metre\\tothe{-1}", 1e-6, ()),
        ("\\one", 1.0, ()),
    ],
)
def test_a_unit_is_read(text: str, factor: float, kind: tuple[str, ...]) -> None:
    unit = read_unit(text)
    assert unit.factor == pytest.approx(factor, rel=1e-14)
    assert unit.kind == kind


NO_UNITS = ("", "mm", "\\inch", "\\metre\\per", "\\milli", "\\per\\metre", "\\tothe{2}", "\\metre{2}", "\\metre x")


@pytest.mark.parametrize("text", NO_UNITS)
def test_what_is_no_unit_is_refused(text: str) -> None:
    with refused(NoQuantity):
        read_unit(text)


def element(text: str) -> object:
    return etree.fromstring(text.replace("<si:real>", '<si:real xmlns:si="https://ptb.de/si">', 1))


def test_one_sigma_is_u_by_k() -> None:
    found = read_real(element(real(1.2, "\\arcsecond", 1.0, 2.5)))
    assert found.value == pytest.approx(1.2 * ARCSEC, rel=1e-14)
    assert found.std == pytest.approx(0.4 * ARCSEC, rel=1e-14)


def test_later_forms_of_an_uncertainty_are_read() -> None:
    later = (
        "<si:real><si:value>2</si:value><si:unit>\\metre</si:unit><si:measurementUncertaintyUnivariate><si:expandedMU>"
        "<si:valueExpandedMU>3</si:valueExpandedMU><si:coverageFactor>2</si:coverageFactor></si:expandedMU>"
        "</si:measurementUncertaintyUnivariate></si:real>"
    )
    assert read_real(element(later)).std == 1.5


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (real(1.0, "\\metre", 0.0), "found an uncertainty of 0, expected one above 0"),
        (real(1.0, "\\metre", -1.0), "expected one above 0"),
        (real(1.0, "\\metre", 1.0, 0.0), "found coverage factor k 0, expected one above 0"),
        (real(math.nan, "\\metre", 1.0), "expected a number"),
        (real(math.inf, "\\metre", 1.0), "expected a number"),
    ],
)
def test_what_is_no_number_is_refused(text: str, said: str) -> None:
    with refused(NoQuantity):
        read_real(element(text))
