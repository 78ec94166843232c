"""Texts in both languages: names of parameters, sources and references, and the station's sentences in German.

Sentences that are stored with a calibration are in English alone. One is translated if each of its clauses is
known; names of steps and effects pass unchanged.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from procedures.uncertainty import sources
from station.results.parameters_by_name import title_of

LANGUAGES = ("en", "de")


@dataclass(frozen=True, slots=True)
class Bilingual:
    """A text in both languages of the certificate."""

    en: str
    de: str

    def __add__(self, other: "Bilingual") -> "Bilingual":
        """Return this followed by another text, both languages."""
        return Bilingual(self.en + other.en, self.de + other.de)


def joined(texts: Iterable[Bilingual], between: str) -> Bilingual:
    """Return several texts as one: an element holds one text of each language."""
    several = list(texts)
    return Bilingual(*(between.join(getattr(one, lang) for one in several) for lang in LANGUAGES))


PARTED = (("; ", "; "), (" with ", " mit "), (" and ", " und "))  # what joins clauses, coarsest first
VERDICTS = {
    "consistent": "verträglich mit Rauschen",
    "established": "Ursache gesichert",
    "likely": "Ursache wahrscheinlich",
    "ambiguous": "mehrdeutig",
    "partly": "zum Teil erklärt",
    "unexplained": "nicht erklärt",
}
ENGLISH = "(englisch)"  # what follows is no German
_CLAUSES = {  # an English clause as a pattern, and its German
    r"twelve-position calibration on a level surface plate": "Kalibrierung in zwölf Lagen auf der Richtplatte",
    r"calibration from (\d+) of (\d+) positions on a level surface plate":
        r"Kalibrierung aus \1 von \2 Lagen auf der Richtplatte",
    r"(\d+) repeated positions?": r"\1 wiederholten Lagen",
    r"(\d+) manual rotations of whole revolutions": r"\1 Drehungen von Hand um ganze Umdrehungen",
    r"(\d+) manual transfers between positions": r"\1 Umlagerungen von Hand von einer zur nächsten",
    r"(\d+) recordings in free positions": r"\1 Aufzeichnungen in freien Lagen",
    r"the serial number was typed in: the unit does not send one":
        "die Seriennummer wurde eingegeben: das Gerät sendet keine",
    r"the closure error of manual rotations was increased from (\S+) to (\S+) deg, because the rotations "
    r"did not meet it":
        r"der Schlussfehler der Drehungen von Hand wurde von \1 auf \2 Grad erhöht, da sie ihn nicht einhielten",
    r"position (\d+) was kept although the cube was tilted by (\S+) deg":
        r"Lage \1 wurde behalten, obwohl der Würfel um \2 Grad geneigt saß",
    r"(.+) was not used": r"\1 wurde nicht verwendet",
    r"(\S+) was recorded (\d+) times, the last one is used": r"\1 wurde \2 mal aufgezeichnet, die letzte gilt",
    r"the software had uncommitted changes":
        "die Software hatte nicht eingecheckte Änderungen",
    r"No diagnosis of the residual is stored with this calibration\.":
        "Zu dieser Kalibrierung ist keine Diagnose des Residuums gespeichert.",
    **{
        rf"Diagnosis of the residual: {verdict}\.": f"Diagnose des Residuums: {german}."
        for verdict, german in VERDICTS.items()
    },
    r"Found in the residual: (.+\.)": r"Im Residuum gefunden (englisch): \1",
    r"Explains the residual only in part: (.+\.)": r"Erklärt das Residuum nur zum Teil (englisch): \1",
    r"Not separated by this campaign: (.+\.)": r"Von dieser Kampagne nicht unterschieden (englisch): \1",
    r"The residuals are consistent with noise: no further error term was detected\.":
        "Die Residuen sind mit Rauschen verträglich: kein weiterer Fehlerterm wurde nachgewiesen.",
    r"The residuals exceed noise, and no known error term explains (?:all of )?it\.":
        "Die Residuen übersteigen das Rauschen, und kein bekannter Fehlerterm erklärt sie ganz.",
    r"The residuals exceed noise, and no known error term explains (?:all of )?it\. The unexplained part is "
    r"included in U\.": "Die Residuen übersteigen das Rauschen, und kein bekannter Fehlerterm erklärt sie ganz. "
    "Der unerklärte Teil ist in U enthalten.",
    r"Heading of a position: u = (\S+)": r"Azimut einer Lage: u = \1",
    r"Closure error of a rotation: u = (\S+)": r"Schlussfehler einer Drehung: u = \1",
    r"Tilt of the surface plate: estimated, prior standard uncertainty (\S+)":
        r"Neigung der Richtplatte: geschätzt, Vorgabe der Standardunsicherheit \1",
    r"Time base: the device\u2019s own clock": "Zeitbasis: die Uhr des Geräts",
    r"rate assumed correct, relative u = (\S+), a stated value":
        r"Gang als richtig angenommen, relativ u = \1, ein Angabewert",
    r"(\S+): (accelerometer|gyroscope) (\w) shows (?:one|no) count edge; its rate is only known to lie in "
    r"(.+) count/s":
        r"\1: \2 \3 zeigt höchstens eine Zählflanke; seine Rate liegt in \4 count/s, mehr ist nicht bekannt",
    r"([a-z_]+(?:\.[a-z_]+)+)": r"\1",
    r"([a-z_]+(?:\.[a-z_]+)+) \(with misalignment\)": r"\1 (mit der Fehlausrichtung)",
    r"(\S+) against (\S+): (\d+) combinations?": r"\1 gegen \2: \3 Kombinationen",
    r"not compared with a reference here": "hier mit keinem Normal verglichen",
    r"deviation from GNSS time recorded with the counts (\S+ ppm, u = \S+ ppm)":
        r"gegen gleichzeitig aufgezeichnete GNSS-Zeit abweichend um \1",
    r"Laboratory\u2019s clock: (.+); stated by the laboratory, the device was not compared with it":
        r"Uhr des Labors: \1; nach Angabe des Labors, das Gerät wurde nicht mit ihr verglichen",
    r"warm-up was skipped: biases may drift by (\S+) deg/h and (\S+) ug \(standard uncertainty\)":
        r"das Einlaufen wurde ausgelassen: Nullpunkte können um \1 deg/h und \2 ug wandern (Standardunsicherheit)",
    r"Also in the model: (.+), as defined by the file of SHA-256 ([0-9a-f]+)\.":
        r"Auch im Modell: \1, festgelegt durch die Datei mit SHA-256 \2.",
    r"the certificate of (cube|slab|site) (\S+) expired on (\S+)": r"der Schein von \1 \2 lief am \3 ab",
    r"(cube|slab|site) (\S+) has no certificate": r"\1 \2 hat keinen Schein",
    r"no (cube|slab|site) is named": r"kein \1 ist genannt",
}  # fmt: skip
_WORDS = {
    "accelerometer": "Beschleunigungsmesser",
    "gyroscope": "Kreisel",
    "cube": "Würfel",
    "slab": "Richtplatte",
    "site": "Ort",
}
_KNOWN = [(re.compile(pattern), german) for pattern, german in _CLAUSES.items()]


def in_german(sentence: str) -> str | None:
    """Return a sentence of the station in German; None of one that it does not know."""
    return _translated(sentence, PARTED)


def _translated(text: str, parted: tuple[tuple[str, str], ...]) -> str | None:
    if (whole := _clause(text)) is not None or not parted:
        return whole
    (english, german), finer = parted[0], parted[1:]
    clauses = [_translated(part, finer) for part in text.split(english)]
    known = [clause for clause in clauses if clause is not None]
    return german.join(known) if len(known) == len(clauses) else None


def _clause(text: str) -> str | None:
    for pattern, german in _KNOWN:
        if found := pattern.fullmatch(text):
            if ENGLISH in german:
                return found.expand(german)
            return re.sub(
                r"(?<![\w.])(cube|slab|site|accelerometer|gyroscope)(?![\w.])",
                lambda word: _WORDS[word[0]],
                found.expand(german),
            )
    return None


TRIAD_NAMES = {
    "accelerometer": Bilingual("accelerometer", "Beschleunigungsmesser"),
    "gyroscope": Bilingual("gyroscope", "Kreisel"),
}
PART_NAMES = {
    "scale_factor": Bilingual("scale factor", "Skalenfaktor"),
    "misalignment": Bilingual("misalignment", "Fehlausrichtung"),
    "bias": Bilingual("bias", "Nullpunktabweichung"),
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


def parameter_name(name: str) -> Bilingual:
    """Return a parameter in words: ``accelerometer.bias.x`` is "accelerometer bias x"."""
    owner, part, *axis = name.split(".")
    if owner not in TRIAD_NAMES or part not in PART_NAMES:
        return Bilingual(title_of(name), f"{LIMITED_NAMES.get(owner, owner)}: {title_of(name)}")
    german = f"{TRIAD_NAMES[owner].de}, {PART_NAMES[part].de} {' '.join(axis)}"
    return Bilingual(title_of(name), german)


def source_name(source: str) -> Bilingual:
    """Return a source of uncertainty in words."""
    return Bilingual(source, SOURCE_NAMES.get(source, source))


def as_written(text: str) -> Bilingual:
    """Return a sentence that is stored in English alone: in German if it is known, else marked as English."""
    return Bilingual(text, in_german(text) or f"{ENGLISH} {text}")
