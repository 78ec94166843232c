"""Under which conditions the campaign was measured, as lines to print."""

from collections.abc import Iterator, Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign, Fixture
from procedures.frames import AXES, FACES
from procedures.units import ARCSEC_PER_RAD
from station.text import MINUS, decimals, fixed, plural, significant


def condition_lines(campaigns: Sequence[Campaign], solution: Solution) -> list[tuple[str, str]]:
    """Return label and text of each condition; those equal in all campaigns once."""
    lines: dict[str, list[str]] = {}
    for campaign in campaigns:
        for label, text in _conditions(campaign):
            texts = lines.setdefault(label, [])
            if text not in texts:
                texts.append(text)
    if solution.reference_temperature is not None:
        lines["Reference temperature"] = [f"{fixed(solution.reference_temperature, 1)} \u00b0C"]
    return [(label, "; ".join(texts)) for label, texts in lines.items()]


def temperature_range(campaigns: Sequence[Campaign]) -> tuple[float, float] | None:
    """Return the least and the greatest temperature [degC] of all steps, None if none was measured."""
    series = [dwell.series for campaign in campaigns for dwell in campaign.dwells]
    series += [turn.series for campaign in campaigns for turn in campaign.turns]
    seen = [one.temperature[np.isfinite(one.temperature)] for one in series]
    measured = np.concatenate(seen) if seen else np.empty(0)
    return (float(measured.min()), float(measured.max())) if measured.size else None


def _conditions(campaign: Campaign) -> Iterator[tuple[str, str]]:
    site, sigma, span = campaign.site, campaign.sigma, temperature_range([campaign])
    places = max(decimals(site.gravity_std), 0) if site.gravity_std > 0 else 6
    gravity, std = fixed(site.gravity, min(places, 9)), significant(site.gravity_std)
    yield "Latitude", f"{fixed(float(np.degrees(site.latitude)), 4)}\u00b0"
    yield "Local gravity", f"{gravity}\u00a0m/s\u00b2, u\u00a0=\u00a0{std}\u00a0m/s\u00b2"
    yield "Heading of a position", f"u\u00a0=\u00a0{significant(float(np.degrees(sigma.heading)))}\u00b0"
    yield "Closure error of a rotation", f"u\u00a0=\u00a0{significant(float(np.degrees(sigma.closure)))}\u00b0"
    yield "Steps", f"{plural(len(campaign.dwells), 'dwell')}, {plural(len(campaign.turns), 'rotation')}"
    yield "Temperature", "not measured" if span is None else f"{span[0]:.1f} to {span[1]:.1f} \u00b0C"
    yield "Fixture", campaign.fixture.id or "not named"
    yield "Face certificate", _certificate(campaign.fixture)
    yield "IMU axes in the cube", ", ".join(_signed_axis(row) for row in campaign.fixture.C_sb)


def _certificate(fixture: Fixture) -> str:
    certified = [face for face in FACES if face in fixture.faces]
    if fixture.measured is not None:
        return f"none; measured by {', '.join(fixture.measured.units) or 'IMUs'}"
    if not certified:
        return "none: misalignment refers to the mean of the cube's faces"
    stds = [float(np.sqrt(np.trace(fixture.faces[face].covariance) / 2)) for face in certified]
    arcsec = significant(max(stds) * ARCSEC_PER_RAD)
    return f"{len(certified)} of {len(FACES)} faces, u up to {arcsec} arcsec"


def _signed_axis(row: FloatArray) -> str:
    greatest = int(np.argmax(np.abs(row)))
    return ("+" if row[greatest] > 0 else MINUS) + AXES[greatest]
