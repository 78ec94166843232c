"""A measured cube as text to read: values in urad and arcsec, each with 1 sigma."""

from collections.abc import Iterator, Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.cube_drift import CubeDrift
from procedures.campaign.measured_cube import NAMES, CubeMeasurement, common_and_difference
from procedures.units import RAD_PER_ARCSEC, RAD_PER_URAD
from station.results.cube_measurement.known_faces import CubeStudy, KnownCube, drift_of
from station.results.cube_measurement.observable import not_observable
from station.results.solution_text import measured
from station.text import table_lines

MIN_CHI2 = 1e-6  # below it, what is left is rounding


def study_text(found: CubeStudy) -> str:
    """Return all that `station fixtures measure` prints."""
    units = ", ".join(f"{unit} ({len(each)})" for unit, each in found.campaigns.items())
    lines = [f"cube {found.cube}, {found.measured_utc:%Y-%m-%d}, by {units}; +- is the standard uncertainty u"]
    lines += values(found.measured)
    if (m := found.measured).dof:
        lines.append(
            f"consistency of the units and the K2 range: chi-square {chi2_text(m.chi2, 4)} at {m.dof} "
            f"degrees of freedom, p {m.p_value:.2g}"
        )
    lines += [f"not observable: {each}" for each in not_observable(found.measured)]
    lines += [f"warning: {each}" for each in found.warnings]
    lines += known_lines(found.with_this)
    return "\n".join(lines)


def values(found: CubeMeasurement) -> list[str]:
    """Return a line for each value, and for the differences, which K2 cannot imitate."""
    names, H = common_and_difference(found.cube.names)
    less = [" less " in name for name in names]
    G, those = H[less], [name for name in names if " less " in name]
    rows = [*_rows(found.cube.names, found.cube.value, found.cube.covariance)]
    rows += [(name, "not determined", "") for name in NAMES if name not in found.cube.names]
    rows += _rows(those, G @ found.cube.value, G @ found.cube.covariance @ G.T)
    return table_lines(rows, "<<<", ("", "urad", "arcsec"))


def _rows(names: Sequence[str], value: FloatArray, covariance: FloatArray) -> Iterator[tuple[str, str, str]]:
    for name, v, s in zip(names, value, np.sqrt(np.diag(covariance)), strict=True):
        yield name, measured(v / RAD_PER_URAD, s / RAD_PER_URAD), measured(v / RAD_PER_ARCSEC, s / RAD_PER_ARCSEC)


def known_lines(known: KnownCube) -> list[str]:
    """Return how the last measurement agrees with the certificate and each one before it, and the cube's drift."""
    lines = list[str]()
    if (found := known.comparison) is not None:
        lines.append(
            f"against the certificate of its faces: chi-square {chi2_text(found.chi2, 4)} of {len(found.names)} "
            f"values, p {found.p_value:.2g}"
        )
        rows = _shifts(found.names, found.difference, found.std)
        lines += table_lines(rows, "<<<", ("", "urad", "sigma"))
    *earlier, last = known.measured
    for one in earlier:
        if shared := len(one.sources & last.sources):
            said = (
                f"{shared} of {len(one.sources)} campaigns are the same: not independent, not used for the drift"
            )
        else:
            said = _since(drift_of([one, last]))
        lines.append(f"against the measurement of {one.measured_utc:%Y-%m-%d}: {said}")
    if (moved := known.drift) is not None:
        days = [f"{one.measured_utc:%Y-%m-%d}" for one in known.independent]
        lines.append(f"drift over {len(days)} measurements, {days[0]} to {days[-1]}")
        lines += _trends(moved)
    return lines


def verdict(moved: CubeDrift) -> str:
    """Say whether a cube has changed."""
    if not moved.changed:
        return (
            f"no significant change (smallest p {moved.p_adjusted.min():.2g}, Holm over {len(moved.names)} values)"
        )
    return f"the cube has changed: {', '.join(moved.changed)} (p {moved.p_adjusted.min():.2g}, Holm)"


def chi2_text(value: float, digits: int) -> str:
    """Return a chi-square with so many significant digits, 0 where it is rounding."""
    return f"{value if value >= MIN_CHI2 else 0.0:.{digits}g}"


def _since(moved: CubeDrift | None) -> str:
    if moved is None:
        return "no value in common"
    sigmas = moved.shift / moved.shift_std
    most = int(np.argmax(np.abs(sigmas)))
    return f"{verdict(moved)}; largest {moved.names[most]}: {sigmas[most]:+z.1f} u"


def _shifts(names: Sequence[str], shift: FloatArray, std: FloatArray) -> Iterator[tuple[str, str, str]]:
    for name, v, s in zip(names, shift, std, strict=True):
        yield name, measured(v / RAD_PER_URAD, s / RAD_PER_URAD), f"{v / s:+z.1f}"


def _trends(moved: CubeDrift) -> Iterator[str]:
    rows = []
    shifts = _shifts(moved.names, moved.shift, moved.shift_std)
    for shift, slope, std, *chi2 in zip(
        shifts, moved.trend, moved.trend_std, moved.chi2, moved.chi2_of_trend, strict=True
    ):
        trend = measured(slope / RAD_PER_URAD, std / RAD_PER_URAD) if np.isfinite(std) else "-"
        constant, line = (chi2_text(each, 3) for each in chi2)
        rows.append((*shift, trend, constant, line if moved.dof > 1 else "-"))
    chi2_of = (f"chi2 of\nconst ({moved.dof})", f"of line\n({moved.dof - 1})")
    yield from table_lines(rows, "<<<<<<", ("", "moved\nurad", "sigma", "urad/month", *chi2_of))
    yield f"  {verdict(moved)}"
