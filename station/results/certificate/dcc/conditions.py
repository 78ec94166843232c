"""The influence conditions of a digital certificate: temperatures, humidity, gravity, place."""

from typing import Any

from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.dsi_units import DEGREE, DEGREE_CELSIUS, METRE, METRE_PER_S2, PERCENT, DsiUnit
from station.results.certificate.dcc.elements import Element, Said, dcc, worded
from station.results.certificate.dcc.quantities import Expanded, no_quantity, of_normal, quantity, real


def influence_conditions(content: CertificateContent) -> Element:
    """Return temperatures, humidity, gravity and latitude, as far as they are known."""
    document, lab = content.document, content.certificate.laboratory
    site, std = document["site"], document["site"]["gravity_std_m_s2"]
    known = [
        _span("unit", UNIT_TEMPERATURE, "basic_temperature", document.get("temperature_range_c"), DEGREE_CELSIUS),
        _span("room", ROOM_TEMPERATURE, "basic_temperature", lab.environment.temperature_c, DEGREE_CELSIUS),
        _span("room", HUMIDITY, "basic_humidityRelative", lab.environment.humidity_percent, PERCENT),
        _one(GRAVITY, site["gravity_m_s2"], METRE_PER_S2, "fog_localGravity", of_normal(std)),
        _one(LATITUDE, site["latitude_deg"], DEGREE, "fog_latitude"),
    ]
    if "height_m" in site:
        known.append(_one(HEIGHT, site["height_m"], METRE, "fog_height"))
    if "reference_temperature_c" in document:
        known.append(
            _one(REFERENCE, document["reference_temperature_c"], DEGREE_CELSIUS, "fog_referenceTemperature")
        )
    place = str(site.get("id") or lab.laboratory.location or lab.laboratory.address)
    known.append(_condition(PLACE, "fog_site", no_quantity(PLACE, place)))
    return dcc("influenceConditions", *(one for one in known if one is not None))


UNIT_TEMPERATURE = Said("temperature of the unit", "Temperatur des Geräts")
ROOM_TEMPERATURE = Said("temperature of the laboratory", "Temperatur des Labors")
HUMIDITY = Said("relative humidity", "relative Luftfeuchte")
GRAVITY = Said("local gravity, standard uncertainty", "örtliche Fallbeschleunigung, Standardunsicherheit")
LATITUDE = Said("latitude", "geographische Breite")
HEIGHT = Said("height", "Höhe")
REFERENCE = Said(
    "temperature of the unit that results refer to", "Gerätetemperatur, auf die Ergebnisse sich beziehen"
)
PLACE = Said("site", "Ort")
ENDS = (("Min", Said("least", "kleinste")), ("Max", Said("greatest", "größte")))


def _span(of: str, name: Said, ref_type: str, span: Any, unit: DsiUnit) -> Element | None:
    if not span:
        return None
    ends = [
        quantity(name + Said(f", {word.en}", f", {word.de}"), real(value, unit), ref_type=f"{ref_type}{end}")
        for value, (end, word) in zip(span, ENDS, strict=True)
    ]
    return _condition(name, f"{ref_type} fog_{of}", *ends)


def _one(name: Said, value: float, unit: DsiUnit, ref_type: str, expanded: Expanded | None = None) -> Element:
    return _condition(name, ref_type, quantity(name, real(value, unit, expanded)))


def _condition(name: Said, ref_type: str, *quantities: Element) -> Element:
    return dcc("influenceCondition", worded("name", name), dcc("data", *quantities), refType=ref_type)
