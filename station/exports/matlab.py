"""MATLAB and GNU Octave: a function file that works a sample out, and a .mat of the numbers that it takes.

Its terms and rounds are those of the program in C. Numbers are double.
"""

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.io import savemat

from procedures.effects.temperature_history import REVERSAL_K
from procedures.frames import TRIADS
from procedures.units import RAD_PER_DEG, STANDARD_GRAVITY
from station.calibrated.correction_inputs import KEPT_S, MIN_SLOPE_S, SLOPE_S
from station.exports import Request
from station.exports.c99 import DIGITS, WANTED
from station.exports.c_and_matlab_expressions import MatlabExpressions
from station.exports.exported_calibration import StoredCalibration, carried_effects
from station.exports.known_samples import Sample, known_samples, rounds_needed
from station.exports.program_text import (
    OUTPUTS,
    SHORT,
    about,
    inputs_of,
    lags_of,
    tables_of,
    templates,
    terms_of,
)


def files(stored: StoredCalibration, asked: Request) -> dict[str, bytes]:
    """Return the bytes of the function and of the .mat by suffix; raises `DataRefused` as the program in C."""
    effects, left = carried_effects(stored)
    rounds = rounds_needed(stored, effects, WANTED[False])
    lags = lags_of(effects)
    write = MatlabExpressions(lags)
    terms = {
        name: terms_of(effects, name, write, "calibration.{table}(:, {next})", ".*") for name in stored.triads
    }
    context = {
        "prefix": asked.prefix, "about": about(stored, effects, left, rounds, DIGITS[False]),
        "inputs": inputs_of(effects),
        "triads": [
            {
                "name": SHORT[name][0], "input": SHORT[name][1], "first": TRIADS.index(name), "terms": terms[name],
                "per": repr(OUTPUTS[name][1]),
            }
            for name in stored.triads
        ],
        "lags": lags, "taus": f"[{', '.join(map(repr, lags))}]" if lags else "zeros(1, 0)", "reversal": REVERSAL_K,
        "kept_s": KEPT_S, "slope_s": SLOPE_S, "min_slope_s": MIN_SLOPE_S,
        "has_terms": any(terms.values()),
        "has_sine": any("sine(" in each for some in terms.values() for each in some),
    }  # fmt: skip
    numbers: dict[str, Any] = {
        table: one.coefficients for table, one in zip(tables_of(effects), effects, strict=True)
    }
    for name, triad in stored.triads.items():
        short = SHORT[name][0]
        numbers |= {f"{short}_k": triad.k[:, None], f"{short}_bias": triad.D[:, None]}
        numbers[f"{short}_inverse"] = triad.inverse
    numbers |= {
        "rounds": float(rounds.number), "unit": stored.unit, "sha256": stored.sha256,
        "samples": _samples(known_samples(stored, effects, is_float=False)),
    }  # fmt: skip
    stream = io.BytesIO()
    savemat(stream, numbers, long_field_names=True)  # type: ignore[arg-type]  # any file that is open, it says
    text = templates().get_template("matlab.jinja").render(context)
    return {".m": text.encode(), ".mat": stream.getvalue()}


def _samples(found: Sequence[Sample]) -> dict[str, Any]:
    """Return the samples of the self-test, a row each: two halves, of which each begins with an empty state."""
    return {
        "counts": np.array([one.counts for one in found]),
        "temperature": np.array([[one.temperature] for one in found]),
        "dt_s": np.array([[one.dt_s] for one in found]),
        "force": np.array([one.force for one in found]) * STANDARD_GRAVITY,
        "rate": np.array([one.rate for one in found]) * RAD_PER_DEG,
    }
