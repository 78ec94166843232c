"""One trial: a campaign with something planted, diagnosed, and what became of the name."""

from dataclasses import dataclass

import numpy as np

from procedures.diagnosis.diagnosis import diagnose
from procedures.diagnosis.result import Diagnosis
from tests.benchmarks.diagnosing.designs import DESIGNS, unit

# effect: design, coefficients that may be planted, options, nature (bench effects: how wide a size is drawn)
PLANTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "accelerometer.quadratic": ("certified", ("x", "y", "z")),
    "accelerometer.quadratic, free": ("free", ("x", "y", "z")),
    "accelerometer.quadratic, uncertified": ("plain", ("x", "y", "z")),
    "accelerometer.cubic": ("free", ("x", "y", "z")),
    "accelerometer.scale_asymmetry": ("free", ("x", "y", "z")),
    "accelerometer.cross_product": ("free", ("xy", "xz", "yx", "yz", "zx", "zy")),
    "accelerometer.bias_temperature": ("warm", ("x", "y", "z")),
    "accelerometer.scale_temperature": ("two temperatures", ("x", "y", "z")),
    "accelerometer.bias_drift": ("warm", ("x", "y", "z")),
    "accelerometer.relaxation": ("plain", ("x", "y", "z")),
    "gyroscope.g_sensitivity": ("plain", tuple(a + b for a in "xyz" for b in "xyz")),
    "gyroscope.bias_temperature": ("warm", ("x", "y", "z")),
    "gyroscope.scale_temperature": ("two temperatures", ("x", "y", "z")),
    "gyroscope.temperature_rate": ("warm", ("x", "y", "z")),
    "gyroscope.bias_drift": ("warm", ("x", "y", "z")),
    "gyroscope.magnetic": ("plain", tuple(a + b for a in "xyz" for b in "xyz")),
    "gyroscope.scale_asymmetry": ("two speeds", ("x", "y", "z")),
    "gyroscope.scale_nonlinearity": ("two speeds", ("x", "y", "z")),
    "gyroscope.sagnac_sine": ("two speeds", ("x", "y", "z")),
    "slab.tilt": ("plain", ("east", "north")),
    "fixture.face_tilt": ("certified", ("x_up.y", "y_down.z", "z_up.x")),
    "fixture.parallelism": ("plain", ("x.y", "y.z", "z.x")),
    "placement.dwell": ("plain", ("x", "y", "z")),
    "site.azimuth": ("plain", ("value",)),
    "site.gravity": ("two sites", ("value",)),
    "auxiliary.channel": ("auxiliary", ("ax", "ay", "az", "gx", "gy", "gz")),
}


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one trial."""

    effect: str
    seed: int
    word: str  # right, group, missed, wrong, false alarm
    named: tuple[str, ...]
    worst: float  # error of a coefficient over its sigma, nan where none compares
    verdict: str
    seconds: float


GIVEN = {
    "fixture.face_tilt": 1e-5,  # rad: one face alone is not seen, only its pair against the certificate
    "accelerometer.quadratic, uncertified": 1e-5,  # g/g^2: only the faces' plausible range bounds it
}


def sigma_of(name: str, seed: int = 1) -> dict[tuple[int, str], float]:
    """Return 1 sigma of each coefficient of an effect in its design, by position (0: any), without it planted."""
    effect, design = name.split(",")[0], DESIGNS[PLANTS[name][0]]
    from procedures.calibration import fit
    from procedures.diagnosis.candidates import candidates
    from procedures.diagnosis.evidence import evidence_of
    from procedures.effects import EFFECTS

    fits = fit(design.make(unit(seed, **design.truth), seed, ()))
    evidence = evidence_of(fits)
    ways = candidates(evidence, fits, [e for e in EFFECTS if e.name == effect])[effect]
    found: dict[tuple[int, str], float] = {}
    for way in ways:
        _, C = way.fit(evidence, (), np.ones(len(evidence.residual))).coefficients()
        std = np.sqrt(np.diag(C))
        if effect == "gyroscope.sagnac_sine":
            std = np.sqrt(std)  # of its square, which is what is linear
        for key, one in zip(way.columns.coefficients, std, strict=True):
            at = (int(way.columns.where.get("position", 0)), key)
            if way.columns.shape in {"", "u|u|", "tau 30 s"} or at not in found:
                found[at] = GIVEN.get(name, float(one))
    return found


def judge(diagnosis: Diagnosis, effect: str) -> tuple[str, tuple[str, ...]]:
    """Return the word for what was found of a planted effect ('' for none), and the names claimed."""
    named = tuple(f.effect for f in diagnosis.findings)
    claims = [f for f in diagnosis.findings if f.kind == "instrument" and f.confidence != "ambiguous"]
    wrong = [f.effect for f in claims if f.effect != effect]
    if wrong:
        return ("wrong" if effect else "false alarm"), named
    if not effect:
        return "right", named
    for finding in diagnosis.findings:
        if finding.effect == effect:
            return ("right" if finding.confidence != "ambiguous" else "group"), named
        if effect in finding.aliases:
            return "group", named
    return "missed", named


def diagnosed(name: str, sizes: dict[str, float], seed: int) -> Diagnosis:
    """Plant and diagnose."""
    effect, (design, _) = name.split(",")[0], PLANTS[name]
    make = DESIGNS[design]
    truth = unit(seed, **make.truth, effects={effect: sizes} if sizes else {})
    return diagnose(make.make(truth, seed, ()))
