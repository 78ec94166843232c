"""The names of parameters, sources and references in both languages."""

from procedures.uncertainty import sources
from station.results.certificate.dcc.elements import Said
from station.results.certificate.dcc.german import in_german
from station.results.parameters_by_name import title_of

TRIAD_NAMES = {
    "accelerometer": Said("accelerometer", "Beschleunigungsmesser"),
    "gyroscope": Said("gyroscope", "Kreisel"),
}
PART_NAMES = {
    "scale_factor": Said("scale factor", "Skalenfaktor"),
    "misalignment": Said("misalignment", "Fehlausrichtung"),
    "bias": Said("bias", "Nullpunktabweichung"),
}
SOURCE_NAMES = {
    sources.COUNTING: "Zählrauschen",
    sources.QUANTISATION: "Quantisierung",
    sources.INSTABILITY: "Instabilität des Nullpunkts",
    sources.WARM_UP: "Einlaufen",
    sources.TURN_ON: "Einschalten",
    sources.REST_SCATTER: "Streuung der Ruhelagen",
    sources.MOVE_SCATTER: "Streuung der Umlagerungen",
    sources.CONING: "Drehung zwischen zwei Abtastungen",
    sources.SECOND_ORDER: "offene Fehlausrichtung",
    sources.CUBE: "Würfel",
    sources.SLAB: "Richtplatte",
    sources.HEADING: "Azimut",
    sources.SEAT: "Sitz auf der Richtplatte",
    sources.CLOSURE: "Schluss der Drehung",
    sources.GRAVITY: "Schwere",
    sources.FRAME: "festgehaltenes Bezugssystem",
    sources.LATITUDE: "geographische Breite",
    sources.CLOCK: "Uhr",
    sources.TEMPERATURE: "Temperatur",
    sources.EFFECTS: "hinzugenommene Effekte",
    sources.UNEXPLAINED: "nicht erklärt",
}
LIMITED_NAMES = {"residual": "Residuum", "slab": "Richtplatte", "fixture": "Würfel"}


def parameter_name(name: str) -> Said:
    """Return a parameter in words: ``accelerometer.bias.x`` is "accelerometer bias x"."""
    owner, part, *axis = name.split(".")
    if owner not in TRIAD_NAMES or part not in PART_NAMES:
        return Said(title_of(name), f"{LIMITED_NAMES.get(owner, owner)}: {title_of(name)}")
    german = f"{TRIAD_NAMES[owner].de}, {PART_NAMES[part].de} {' '.join(axis)}"
    return Said(title_of(name), german)


def source_name(source: str) -> Said:
    """Return a source of uncertainty in words."""
    return Said(source, SOURCE_NAMES.get(source, source))


def as_written(text: str) -> Said:
    """Return a sentence that is stored in English alone: in German if it is known, else marked as English."""
    return Said(text, in_german(text) or f"(englisch) {text}")
