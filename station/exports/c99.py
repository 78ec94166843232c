"""C99 for a microcontroller: a header and a source that turn counts into specific force and angular rate.

They use math.h and no memory but a small struct: what effects remember of the temperature. Effects depend on what
they correct: a fixed number of rounds settles that, with what is left of it in a comment.
"""

import re

import numpy as np

from procedures.effects.temperature_history import REVERSAL_K
from procedures.frames import TRIADS
from procedures.units import RAD_PER_DEG, STANDARD_GRAVITY
from station.calibrated.applied_effects import AppliedEffect
from station.calibrated.correction_inputs import KEPT, KEPT_S, MIN_SLOPE_S, SLOPE_S
from station.exports import Request
from station.exports.c_and_matlab_expressions import CExpressions, c_functions
from station.exports.exported_calibration import StoredCalibration, carried_effects
from station.exports.known_samples import AUXILIARY, MAGNETIC_UT, Sample, known_samples, rounds_needed
from station.exports.program_text import (
    OUTPUTS,
    SHORT,
    about,
    inputs_of,
    lags_of,
    plain,
    tables_of,
    templates,
    terms_of,
)

WANTED = {False: 1e-15, True: 3e-8}  # of the input's length, that rounds may leave: what rounding does anyway
LIMIT = {False: "1e-12", True: "1e-6"}  # of the self-test
DIGITS = {False: "double, to 1e-12 of a vector's length", True: "float, to about 1e-6 of a vector's length"}
_FILES = {".h": "header", ".c": "source"}


def files(stored: StoredCalibration, asked: Request) -> dict[str, bytes]:
    """Return the header and the source by suffix.

    Raise `DataRefused` if an effect is not what was stored, has no finite value, or does not settle.
    """
    is_float = asked.is_float
    effects, left = carried_effects(stored)
    rounds = rounds_needed(stored, effects, WANTED[is_float])
    samples = known_samples(stored, effects, is_float=is_float)
    write = CExpressions(lags_of(effects), c_functions(is_float), is_float)
    context = _context(stored, effects, write) | {
        "prefix": asked.prefix, "about": about(stored, effects, left, rounds, DIGITS[is_float]),
        "limit": LIMIT[is_float], "rounds": rounds.number, "residual": str(rounds),
        "vectors": [_vector(one, write) for one in samples],
    }  # fmt: skip
    texts = {end: templates().get_template(f"c_{name}.jinja") for end, name in _FILES.items()}
    return {end: text.render(context).encode() for end, text in texts.items()}


def _context(
    stored: StoredCalibration, effects: tuple[AppliedEffect, ...], write: CExpressions
) -> dict[str, object]:
    has_rate = any("T_rate" in one.inputs for one in effects)
    lags, row = write.lags, write.row
    terms = {name: terms_of(effects, name, write, "{table}[i][{column}]", "*") for name in stored.triads}
    used = set(re.findall(r"\w+", " ".join(each for some in terms.values() for each in some)))
    return {
        "type": "float" if write.is_float else "double", "f": "f" if write.is_float else "", "n": write.number,
        "triads": [
            {
                "name": SHORT[name][0], "input": SHORT[name][1], "unit": SHORT[name][2],
                "k_unit": plain(str(stored.document[name]["scale_factor"].get("unit", SHORT[name][3]))),
                "first": TRIADS.index(name), "k": row(triad.k), "bias": row(triad.D),
                "inverse": [row(each) for each in triad.inverse], "terms": terms[name],
            }
            for name, triad in stored.triads.items()
        ],
        "effects": [
            {
                "name": one.name, "table": table, "columns": one.coefficients.shape[1],
                "rows": [row(each) for each in one.coefficients],
            }
            for one, table in zip(effects, tables_of(effects), strict=True)
        ],
        "outputs": [_output(name, name in stored.triads, write) for name in TRIADS],
        "used": used, "lags": lags, "taus": row(np.array(lags)), "has_rate": has_rate,
        "lags_in_words": ", ".join(f"{tau:.6g} s" for tau in lags),
        "kept": KEPT, "kept_s": KEPT_S, "slope_s": SLOPE_S, "min_slope_s": MIN_SLOPE_S,
        "has_direction": any("warming" in one.inputs for one in effects), "reversal": REVERSAL_K,
        "inputs": _inputs(effects, write),
        "absent": "".join(f" The {name} is not calibrated: NAN." for name in TRIADS if name not in stored.triads),
    }  # fmt: skip


def _output(triad: str, is_there: bool, write: CExpressions) -> dict[str, str]:
    name, per = OUTPUTS[triad]
    absent = f"({'float' if write.is_float else 'double'})NAN"
    value = f"{SHORT[triad][1]}[i] * {write.number(per)}" if is_there else absent
    return {"name": name, "value": value}


def _inputs(effects: tuple[AppliedEffect, ...], write: CExpressions) -> list[dict[str, object]]:
    return [
        {
            "name": f"{one.variable}[{one.size}]" if one.size > 1 else one.variable, "variable": one.variable,
            "meaning": one.meaning,
            "tested": list(map(write.number, MAGNETIC_UT if one.size > 1 else (AUXILIARY,))),
        }
        for one in inputs_of(effects)
    ]  # fmt: skip


def _vector(one: Sample, write: CExpressions) -> dict[str, str]:
    force, rate = one.force * STANDARD_GRAVITY, one.rate * RAD_PER_DEG
    return {
        "counts": write.row(one.counts), "temperature": write.number(one.temperature),
        "dt_s": write.number(one.dt_s), "force": write.row(np.nan_to_num(force)),
        "rate": write.row(np.nan_to_num(rate)),
    }  # fmt: skip
