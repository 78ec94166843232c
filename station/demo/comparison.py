"""What was found against what was true, parameter by parameter, in sigmas."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np
from scipy.special import erfinv

from drivers.simulated.bench_truth import imu_from_cube
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.dwells_and_turns.mean_cube import mean_cube
from procedures.frames import AXES, TRIADS
from procedures.units import ARCSEC_PER_RAD, DEG_H_PER_DEG_S, PPM_PER_ONE, UG_PER_G
from station.results.parameters_by_name import parameters

_SCALE = {"1": (PPM_PER_ONE, "1e-6"), "g": (UG_PER_G, "ug"), "rad": (ARCSEC_PER_RAD, "arcsec")}


@dataclass(frozen=True, slots=True)
class TrueAndFound:
    """A parameter as found, its 1 sigma and its truth, in ``unit``."""

    title: str
    value: float
    std: float
    truth: float
    unit: str

    @property
    def sigmas(self) -> float:
        """The error in sigmas."""
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
    """Return the comparison as a table."""
    lines = [f"{'parameter':<29}{'found':>14} {'1 sigma':>10}{'truth':>15} {'error/sigma':>12}  unit"]
    for row in rows:
        digits = max(0, min(6, 1 - int(np.floor(np.log10(row.std))))) if row.std > 0 else 6
        lines.append(
            f"{row.title:<29}{row.value:>14.{digits}f} {row.std:>10.{digits}f}{row.truth:>15.{digits}f}"
            f" {row.sigmas:>+12.2f}  {row.unit}"
        )
    rms = float(np.sqrt(np.mean([row.sigmas**2 for row in rows])))
    worst = max(abs(row.sigmas) for row in rows)
    low, high = (float(np.sqrt(2) * erfinv(p ** (1 / len(rows)))) for p in (0.05, 0.95))
    lines.append(f"{len(rows)} parameters: error/sigma {rms:.2f} rms, {worst:.2f} at most")
    lines.append(f"(honest sigmas give 1 rms, and a largest between {low:.1f} and {high:.1f} nine times in ten)")
    return "\n".join(lines)


def _titles() -> Iterator[tuple[str, str]]:
    """Yield the parameters' names, and what they are called, in the table's order."""
    pairs = list(permutations(AXES, 2))
    for triad in TRIADS:
        yield from ((f"{triad}.scale_factor.{axis}", f"{triad} k {axis}") for axis in AXES)
        yield from ((f"{triad}.bias.{axis}", f"{triad} D {axis}") for axis in AXES)
        yield from ((f"{triad}.misalignment.{q}{p}", f"{triad} E {q}{p}") for q, p in pairs)
    yield from ((f"slab.tilt.{side}", f"slab tilt {side}") for side in ("east", "north"))
    yield from ((f"fixture.parallelism.{q}.{p}", f"parallelism {q} faces, {p}") for q, p in pairs)


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
