"""Results compared with the simulator's truth, parameter by parameter, and what the diagnosis found."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, permutations
from typing import Any

import numpy as np
from scipy.special import erfc, erfinv

from drivers.simulated.truth import Truth, imu_from_cube
from procedures.arrays import FloatArray
from procedures.frames import AXES, TRIADS
from procedures.twelve_positions.bench_parameters import mean_cube
from procedures.units import ARCSEC_PER_RAD, DEG_H_PER_DEG_S, PPM_PER_ONE, UG_PER_G
from station.demo.device import COEFFICIENT, EFFECT, KEY
from station.results.diagnosis.finding_wording import most_reduced, probability_text
from station.results.parameters_by_name import parameters

NOTABLE = 2.0  # standard uncertainties, which one error in twenty exceeds
LIKELY = 0.95  # of runs, whose largest error is smaller than the one that is commented
_SCALE = {"1": (ARCSEC_PER_RAD, "arcsec"), "g": (UG_PER_G, "ug"), "rad": (ARCSEC_PER_RAD, "arcsec")}


@dataclass(frozen=True, slots=True)
class TrueAndFound:
    """A parameter as found, its standard uncertainty and its truth, in ``unit``."""

    title: str
    value: float
    std: float
    truth: float
    unit: str

    @property
    def sigmas(self) -> float:
        """The error in standard uncertainties."""
        return (self.value - self.truth) / self.std


def compared(document: Mapping[str, Any], truth: Mapping[str, float]) -> list[TrueAndFound]:
    """Return every parameter of a `solution/1` whose truth is known."""
    known, found = parameters(document), list[TrueAndFound]()
    for name, title in _titles():
        if name in truth and (one := known.get(name)) is not None and one.std is not None:
            scale, shown = _SCALE.get(one.unit, (1.0, one.unit))
            found.append(TrueAndFound(title, one.value * scale, one.std * scale, truth[name] * scale, shown))
    return found


def comparison_text(rows: list[TrueAndFound]) -> str:
    """Return the comparison as a table, a line per kind of parameter; u is the standard uncertainty."""
    lines = [f"{'parameter':<28}{'error rms':>11}{'u rms':>11}  {'unit':<8}{'largest error/u':>17}"]
    for kind, same in groupby(rows, lambda row: row.title.rpartition(" ")[0]):
        group = list(same)
        is_scale = group[0].unit.startswith("count/")  # whose errors are relative
        unit, scale = ("ppm", [PPM_PER_ONE / row.truth for row in group]) if is_scale else (group[0].unit, 1.0)
        error = _rms(np.array([row.value - row.truth for row in group]) * scale)
        u = _rms(np.array([row.std for row in group]) * scale)
        largest = max((row.sigmas for row in group), key=abs)
        mark = " *" if abs(largest) > NOTABLE else ""
        lines.append(f"{kind:<28}{error:>11.2g}{u:>11.2g}  {unit:<8}{largest:>+17.2f}{mark}")
    rms, many = _rms([row.sigmas for row in rows]), sum(abs(row.sigmas) > NOTABLE for row in rows)
    expected = len(rows) * erfc(NOTABLE / np.sqrt(2))
    lines.append(f"{len(rows)} parameters: error/u is {rms:.2f} rms (expected: 1); * above {NOTABLE:g}: {many}")
    lines.append(f"(about {expected:.1f} of {len(rows)} are expected above {NOTABLE:g}) {_comment(rows)}".rstrip())
    return "\n".join(lines)


def _comment(rows: Sequence[TrueAndFound]) -> str:
    """Return what is to be reported of the largest error; nothing where nine of ten runs have a smaller one."""
    worst = max(abs(row.sigmas) for row in rows)
    high = float(np.sqrt(2) * erfinv(LIKELY ** (1 / len(rows))))
    return "" if worst <= high else f"! {worst:.1f} is larger than in {100 * LIKELY:.0f} of 100 runs"


def _rms(values: Sequence[float] | FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _titles() -> Iterator[tuple[str, str]]:
    """Yield the parameters' names, and what they are called, in the table's order."""
    pairs = list(permutations(AXES, 2))
    for triad in TRIADS:
        yield from ((f"{triad}.scale_factor.{axis}", f"{triad} scale factor {axis}") for axis in AXES)
        yield from ((f"{triad}.bias.{axis}", f"{triad} bias {axis}") for axis in AXES)
        yield from ((f"{triad}.misalignment.{q}{p}", f"{triad} misalignment {q}{p}") for q, p in pairs)
    yield from ((f"slab.tilt.{side}", f"slab tilt {side}") for side in ("east", "north"))
    yield from ((f"fixture.parallelism.{q}.{p}", f"face parallelism {q}{p}") for q, p in pairs)


def truth_values(truth: Truth, *, is_certified: bool = False) -> dict[str, float]:
    """Return the truth keyed as `procedures.calibration.solution_values.Solution.names`.

    Misalignment and scale factor refer to the mean cube, as the solution's do: columns of ``k E`` along the mean
    normals of the face pairs instead of the cube's own axes, to which those of a certified cube refer.
    """
    up, down = truth.faces_rad[::2], truth.faces_rad[1::2]  # (3, 2) each, by face pair
    C_sb = imu_from_cube(truth.imu_axes)
    mean = np.eye(3) if is_certified else C_sb @ mean_cube((up - down) / 2) @ C_sb.T
    values = {
        **_triad_truth("accelerometer", truth.accel_k, truth.accel_e @ mean, truth.accel_d_g),
        **_triad_truth("gyroscope", truth.gyro_k, truth.gyro_e @ mean, truth.gyro_d_deg_s * DEG_H_PER_DEG_S),
        "slab.tilt.east": float(truth.slab_tilt_rad[0]),
        "slab.tilt.north": float(truth.slab_tilt_rad[1]),
    }
    for i, pair in enumerate(AXES):
        for j, other in enumerate(axis for axis in AXES if axis != pair):
            values[f"fixture.parallelism.{pair}.{other}"] = float(up[i, j] + down[i, j])
    return values


def _triad_truth(name: str, k: FloatArray, E: FloatArray, D: FloatArray) -> dict[str, float]:
    length = np.linalg.norm(E, axis=1)
    values = {}
    for q, sensor in enumerate(AXES):
        values[f"{name}.scale_factor.{sensor}"] = float(k[q] * length[q])
        values[f"{name}.bias.{sensor}"] = float(D[q] / length[q])
        for p, body in enumerate(AXES):
            values[f"{name}.misalignment.{sensor}{body}"] = float(E[q, p] / length[q])
    return values


SHOWN = 4.0  # standard uncertainties from which on a coefficient is shown that was not planted


def findings_lines(diagnosis: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a `diagnosis/2`."""
    causes = [each for each in diagnosis["findings"] if each["kind"] != "bench"]
    for each in causes:
        yield f"error found that the model lacked: {each['effect']}"
        yield f"  {each['confidence']}, probability {probability_text(each['probability'])}"
        yield from _coefficients(each)
    if not causes:
        yield "no error was found that the model lacked; use longer dwells (--dwell-s 60)"
    if causes and (most := most_reduced(diagnosis)):
        yield f"  {'error of ' + most['quantity']:<32}{'without it':<15}with it"
        for name, where in (("", "in the data"), ("held_out_", "in held-out data")):
            before, after = (f"{most[f'{name}{when}']:.3g} {most['unit']}" for when in ("before", "after"))
            yield f"    {where:<30}{before:<15}{after}"


def _coefficients(finding: Mapping[str, Any]) -> Iterator[str]:
    for name, found in finding["coefficients"].items():
        planted = COEFFICIENT if (finding["effect"], name) == (EFFECT, KEY) else 0.0
        if planted or abs(found["value"]) > SHOWN * found["std"]:
            error = (found["value"] - planted) / found["std"]
            value = f"{found['value']:.4f} {finding['unit']}, u = {found['std']:.4f}"
            yield f"  {name} = {value}; true value {planted:g}"
            if abs(error) > NOTABLE:  # by a wrong field
                yield f"  (error {error:+.1f} u: the assumed magnetic field is a model's, a few % off)"
