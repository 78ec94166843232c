"""What was found against what was true, parameter by parameter, in sigmas."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import erfinv

from drivers.simulated.bench_truth import imu_from_cube
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Estimate, Solution, TriadCalibration
from procedures.dwells_and_turns.bench_parameters import mean_cube
from procedures.frames import AXES
from procedures.units import ARCSEC_PER_RAD, DEG_H_PER_DEG_S, PPM_PER_ONE, UG_PER_G

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


def compared(solution: Solution, truth: Mapping[str, float]) -> list[TrueAndFound]:
    """Return every parameter of a solution whose truth is known."""
    found = list[TrueAndFound]()
    for name, title, value, std, unit in _parameters(solution):
        if name in truth:
            scale, shown = _SCALE.get(unit, (1.0, unit))
            found.append(TrueAndFound(title, value * scale, std * scale, truth[name] * scale, shown))
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


def _parameters(solution: Solution) -> Iterator[tuple[str, str, float, float, str]]:
    for name, triad in (("accelerometer", solution.accelerometer), ("gyroscope", solution.gyroscope)):
        if triad is not None:
            yield from _triad(name, triad)
    if solution.slab_tilt is not None:
        for side, value, std in _each(("east", "north"), solution.slab_tilt):
            yield f"slab.tilt.{side}", f"slab tilt {side}", value, std, "rad"
    if (faces := solution.parallelism) is not None:
        for i, pair in enumerate(AXES):
            others = [axis for axis in AXES if axis != pair]
            row = Estimate(faces.value[i], faces.std[i], faces.unit)
            for other, value, std in _each(others, row):
                yield (
                    f"fixture.parallelism.{pair}.{other}",
                    f"parallelism {pair} faces, {other}",
                    value,
                    std,
                    "rad",
                )


def _triad(name: str, triad: TriadCalibration) -> Iterator[tuple[str, str, float, float, str]]:
    for axis, value, std in _each(AXES, triad.scale_factor):
        yield f"{name}.scale_factor.{axis}", f"{name} k {axis}", value, std, triad.scale_factor.unit
    for axis, value, std in _each(AXES, triad.bias):
        yield f"{name}.bias.{axis}", f"{name} D {axis}", value, std, triad.bias.unit
    E = triad.misalignment.value
    for q, p in np.argwhere(~np.eye(3, dtype=bool)).tolist():
        pair = AXES[q] + AXES[p]
        yield (
            f"{name}.misalignment.{pair}",
            f"{name} E {pair}",
            float(E[q, p]),
            float(triad.misalignment.std[q, p]),
            "1",
        )


def _each(names: tuple[str, ...] | list[str], estimate: Estimate) -> Iterator[tuple[str, float, float]]:
    yield from zip(names, estimate.value.tolist(), estimate.std.tolist(), strict=True)


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
