"""What a report is made from, with the measurement's conditions; written whole or not at all."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from procedures.arrays import FloatArray
from procedures.calibration.solution_values import FitQuality, Solution, TriadCalibration
from procedures.calibration.undetectable_tilt import ANY_TILT_RAD, UndetectableTilt
from procedures.campaign.campaign import Campaign, Fixture
from procedures.frames import AXES, TRIADS
from procedures.positions import FACES
from procedures.uncertainty.budget import ParameterBudget
from procedures.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, UG_PER_G
from station.files.atomic_file import replace_file
from station.results.certificate.printed_results import INFINITE, MAX_CONTRIBUTIONS, Row, budget_rows
from station.results.diagnosis.finding_wording import MIN_LOG10_P, p_text
from station.results.html_templates import html_template
from station.results.report.report_figures import ReportFigures
from station.results.report.result_tables import (
    LIMIT_SIGMAS,
    bench_groups,
    correlations,
    matrix_rows,
    residual_tables,
    triad_groups,
)
from station.results.verdict import verdict_in_words
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


SIGNIFICANT_P = 0.01  # of the global test, below which residuals exceed noise
VERDICT_MARK = {"PASS": "\u2713", "FAIL": "\u2717", "NOT_MEASURED": "\u25cb"}


@dataclass(frozen=True, slots=True, eq=False)
class ReportContext:
    """A solution, the campaigns behind it and what only the caller knows.

    ``files`` holds the SHA-256 of each input by name; ``created_utc`` is printed as it is: with it, equal
    inputs give equal bytes. ``truth`` (simulated campaigns) is keyed as `Solution.names`, in the units of
    files: ``accelerometer.bias.x`` in g. ``calibration_sha256`` is the head of the database's hash chain,
    ``journal`` the code of its journal then.
    ``bench`` adds lines to the conditions, such as a certificate's number and due date. ``budgets`` are the
    uncertainty budgets of the parameters. ``diagnosis`` is the section on what the model lacks, as HTML; ``cause``
    and ``advice`` say in a sentence each what the diagnosis found and what to do, for the first page.
    ``has_limits``: the model has some. ``figures`` are this solution's plots, where they may be drawn already.
    """

    solution: Solution
    campaigns: tuple[Campaign, ...]
    files: Mapping[str, str]
    software: str
    created_utc: str
    verdict: str = "NOT_MEASURED"
    has_limits: bool = False
    verdict_reason: str = "no limits are stored for this IMU model"
    truth: Mapping[str, float] = field(default_factory=dict)
    calibration_sha256: str | None = None
    journal: str | None = None
    bench: Mapping[str, str] = field(default_factory=dict)
    budgets: tuple[ParameterBudget, ...] = ()
    diagnosis: str = ""
    cause: str = ""
    advice: str = ""
    figures: ReportFigures | None = None

    def __post_init__(self) -> None:
        if self.verdict not in VERDICT_MARK:
            raise ValueError(f"verdict {self.verdict!r} is none of {', '.join(VERDICT_MARK)}")
        if not self.campaigns:
            raise ValueError("a report of no campaign, expected at least one")


def report_context(
    solution: Solution,
    campaigns: Sequence[Campaign],
    document: Mapping[str, Any],
    budgets: Sequence[ParameterBudget] = (),
) -> ReportContext:
    """Return the context of a solution and its ``solution/1`` document, which holds the folders' own warnings."""
    origin = document["provenance"]
    reported = replace(
        solution, warnings=tuple(document["warnings"]), unused_steps=tuple(document["unused_steps"])
    )
    return ReportContext(
        solution=reported,
        campaigns=tuple(campaigns),
        files=origin["files"],
        software=origin["software"],
        created_utc=origin["created_utc"],
        budgets=tuple(budgets),
        figures=ReportFigures(reported, campaigns),
    )


def write_report(path: str | Path, context: ReportContext) -> None:
    """Write the report as one self-contained HTML file, replacing an older one in one step.

    Raises
    ------
    CannotWrite
        If the place cannot be written.
    """
    replace_file(Path(path), render(context).encode())


def render(context: ReportContext) -> str:
    """Return the report's HTML; equal contexts give equal text."""
    solution, first = context.solution, context.campaigns[0]
    figures = context.figures or ReportFigures(solution, context.campaigns)
    return html_template("report.html").render(
        context=context,
        model=first.model,
        serial=first.serial,
        verdict=verdict_in_words(context.verdict, has_limits=context.has_limits),
        verdict_mark=VERDICT_MARK[context.verdict],
        quality=solution.quality,
        summary=_summary(context),
        facts=_facts(solution),
        seating=_detectable_seating(solution.undetectable_tilts),
        triads=[_triad(name, triad, context) for name in TRIADS if (triad := getattr(solution, name)) is not None],
        bench=bench_groups(solution, context.truth),
        budget_tables=_budget_tables(context.budgets),
        correlations=correlations(solution),
        residual_tables=residual_tables(solution.residuals),
        residual_plots=figures.residuals,
        limit_sigmas=f"{LIMIT_SIGMAS:g}",
        noise=figures.noise,
        noise_plot=figures.allan,
        conditions=[*condition_lines(context.campaigns, solution), *context.bench.items()],
        files=sorted(context.files.items()),
        diagnosis=Markup(context.diagnosis),
    )


def _triad(name: str, triad: TriadCalibration, context: ReportContext) -> dict[str, object]:
    return {
        "name": name,
        "groups": triad_groups(name, triad, context.truth, {one.name: one.expanded for one in context.budgets}),
        "has_budget": any(one.name.startswith(name) for one in context.budgets),
        "matrix": matrix_rows(triad.misalignment),
    }


def _facts(solution: Solution) -> list[tuple[str, str, str]]:
    quality = solution.quality
    facts = [
        (
            "Residuals against noise",
            p_text(math.log10(max(quality.p_value, 10.0**MIN_LOG10_P))),
            f"{_fits(quality)}; \u03c7\u00b2 = {quality.chi2:.1f}, {quality.dof} degrees of freedom",
        )
    ]
    if quality.accelerometer_rms_g is not None:
        rms = significant(quality.accelerometer_rms_g * UG_PER_G, 3)
        facts.append(("Accelerometer residual", f"{rms} \u00b5g", "rms over all dwells"))
    if quality.gyroscope_rms_dph is not None:
        rms = significant(quality.gyroscope_rms_dph, 3)
        facts.append(("Gyroscope residual", f"{rms} deg/h", "rms over all dwells"))
    return facts


def _fits(quality: FitQuality) -> str:
    if quality.dof == 0:
        return "as many unknowns as measurements: not tested"
    return "residuals exceed noise" if quality.p_value < SIGNIFICANT_P else "residuals are consistent with noise"


def _summary(context: ReportContext) -> list[tuple[str, str]]:
    """Return the first page's rows, in a customer's words: what was measured, the cause found, what to do."""
    positions = {dwell.position for campaign in context.campaigns for dwell in campaign.dwells}
    dwells, turns, moves = (
        sum(len(getattr(campaign, kind)) for campaign in context.campaigns)
        for kind in ("dwells", "turns", "moves")
    )
    parts = [f"{plural(dwells, 'rest')} in {plural(len(positions), 'position')} of the cube"] if dwells else []
    parts += [f"{plural(turns, 'rotation')} by hand"] if turns else []
    parts += [f"{plural(moves, 'transfer')} between positions"] if moves else []
    rows = [("Measured", ", ".join(parts))] if parts else []
    rows += [("Cause found", context.cause)] if context.cause else []
    rows += [("What to do", context.advice)] if context.advice else []
    return rows


def _detectable_seating(tilts: Sequence[UndetectableTilt]) -> str:
    """Say which seating error of the cube the residuals show, and what a smaller one does; nothing without one."""
    if not tilts:
        return ""
    shown = [f"{each.tilt / RAD_PER_ARCSEC:.0f}" for each in sorted(tilts, key=attrgetter("tilt"))]
    shown = shown[: sum(each.tilt <= ANY_TILT_RAD for each in tilts)]
    hidden = sorted({each.position for each in tilts if each.tilt > ANY_TILT_RAD})
    worst = max(tilts, key=attrgetter("sigmas"))
    stated = []
    if shown:
        stated.append(
            f"{' to '.join(dict.fromkeys((shown[0], shown[-1])))} arcsec (detected in half of the cases)."
        )
    if hidden:
        stated.append(
            f"No seating error is detected in position{'s' * (len(hidden) > 1)} {', '.join(map(str, hidden))}."
        )
    is_any = worst.tilt > ANY_TILT_RAD
    which = f"One of {ANY_TILT_RAD / RAD_PER_ARCSEC:.0f} arcsec" if is_any else "A smaller one"
    stated.append(
        f"{which} in position {worst.position} can shift {worst.value} by up to {worst.sigmas:.1f} times its "
        f"standard uncertainty."
    )
    return " ".join(stated)


def _budget_tables(budgets: Sequence[ParameterBudget]) -> list[tuple[str, list[Row]]]:
    """Return triad and printed lines of each triad that has a budget."""
    triads = dict.fromkeys(one.name.split(".")[0] for one in budgets)
    mine = {triad: [one for one in budgets if one.name.split(".")[0] == triad] for triad in triads}
    return [(triad, budget_rows(found, _degrees, _largest)) for triad, found in mine.items()]


def _degrees(dof: float) -> str:
    """Return degrees of freedom rounded down (JCGM 100:2008, G.6.4), or the sign for infinitely many."""
    return str(math.floor(dof)) if math.isfinite(dof) else INFINITE


def _largest(one: ParameterBudget) -> str:
    """Return the sources that make up most of a parameter's variance, largest first, with their share."""
    parts = sorted(one.contributions, key=lambda part: part.std, reverse=True)[:MAX_CONTRIBUTIONS]
    shares = [(part.source, 100 * (part.std / one.std) ** 2) for part in parts if part.std > 0]
    return ", ".join(f"{source} {f'{share:.0f} %' if share >= 1 else '< 1 %'}" for source, share in shares)
