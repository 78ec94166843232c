"""A calibration's report: all that it says as one typed value, laid out as HTML."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from procedures.arrays import FloatArray
from procedures.calibration.solution_values import FitQuality, Solution, StepResidual
from procedures.calibration.undetectable_tilt import ANY_TILT_RAD, UndetectableTilt
from procedures.campaign.campaign import Campaign, Fixture
from procedures.frames import AXES, TRIADS
from procedures.positions import FACES
from procedures.samples.channel_noise import channel_noise
from procedures.samples.held_samples import known_scales
from procedures.uncertainty.budget import ParameterBudget
from procedures.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, UG_PER_G
from station.files.atomic_file import replace_file
from station.results.certificate.printed_results import Row, measured, result_groups
from station.results.diagnosis.diagnosis_html import section_html
from station.results.diagnosis.diagnosis_wording import verdict_sentence
from station.results.diagnosis.finding_wording import MIN_LOG10_P, p_text
from station.results.diagnosis.model_refinement import ModelRefinement, budget_document
from station.results.html_templates import html_template
from station.results.measurement_circumstances import procedure_name
from station.results.parameters_by_name import ParameterKind
from station.results.report.noise_document import noise_channel
from station.results.report.noise_page import noise_section
from station.results.report.result_tables import (
    LIMIT_SIGMAS,
    NOTICE_SIGMAS,
    ParameterGroup,
    ResidualTable,
    TriadResult,
    bench_groups,
    correlations,
    normalised,
    residual_tables,
    triad_results,
)
from station.results.report.svg import AXIS_STYLE, INK, PALE, RULE, draw_svg
from station.results.result_formats import document_of
from station.results.solution_json import SolutionDocument
from station.results.verdict import LimitVerdict, what_to_do
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
NO_LIMITS = LimitVerdict("NOT_MEASURED", (), "no limits are stored for this IMU model")
Lines = Sequence[tuple[str, str]]  # label and text


@dataclass(frozen=True, slots=True)
class ReportedDiagnosis:
    """The section on what the model lacks, as HTML; the cause found and what to do, in a sentence each."""

    section: str = ""
    cause: str = ""
    advice: str = ""


def reported_diagnosis(refined: ModelRefinement, verdict: LimitVerdict, doubt: str = "") -> ReportedDiagnosis:
    """Return what a report says of a refined model's diagnosis; see `what_to_do` for ``doubt``."""
    step, has_limits = refined.document["next_measurement"], bool(verdict.judged)
    return ReportedDiagnosis(
        section_html(refined.document, refined.diagnosis),
        verdict_sentence(refined.document),
        what_to_do(verdict.word, step, doubt=doubt, has_limits=has_limits),
    )


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationReport:
    """All that a report says: every value with unit and uncertainty, every sentence, every plot.

    It is made once; storing adds ``calibration_sha256``, the hash of the stored calibration, and ``journal``, the
    code of the database's journal then. ``facts`` are label, figure and detail, ``budgets`` the results with U.
    ``created_utc`` is printed as it is: equal inputs give equal bytes.
    """

    model: str
    serial: str
    created_utc: str
    software: str
    files: Lines
    verdict: LimitVerdict
    summary: Lines
    facts: Sequence[tuple[str, str, str]]
    triads: tuple[TriadResult, ...]
    bench: tuple[ParameterGroup, ...]
    budgets: Sequence[tuple[str, ParameterKind, list[Row]]]
    residual_tables: Sequence[ResidualTable]
    residual_plots: Sequence[tuple[str, Markup]]
    diagnosis: Markup
    noise: Markup
    conditions: Lines
    seating: str
    not_observable: Sequence[str]
    warnings: Sequence[str]
    unused_steps: Sequence[str]
    correlations: Sequence[tuple[str, str, str, float]]
    is_simulated: bool
    calibration_sha256: str = ""
    journal: str = ""


def calibration_report(
    solution: Solution,
    campaigns: Sequence[Campaign],
    document: SolutionDocument,
    budgets: Sequence[ParameterBudget] = (),
    *,
    verdict: LimitVerdict = NO_LIMITS,
    truth: Mapping[str, float] | None = None,
    bench: Mapping[str, str] | None = None,
    diagnosis: ReportedDiagnosis = ReportedDiagnosis(),
) -> CalibrationReport:
    """Return the report of a solution; its ``document`` has the folders' own warnings.

    ``truth`` (simulated campaigns) is keyed as `Solution.names`, in the units of files; ``bench`` adds conditions.
    """
    origin, known, stated = document.provenance, truth or {}, document_of(document)
    found = channel_noise(campaigns, known_scales(campaigns, solution))
    noise = [noise_channel(one) for one in found]
    return CalibrationReport(
        model=origin.model,
        serial=origin.serial,
        created_utc=origin.created_utc,
        software=origin.software or "",
        files=sorted(origin.files.items()),
        verdict=verdict,
        summary=_summary(campaigns, diagnosis),
        facts=_facts(solution),
        triads=triad_results(stated, known, {one.name: one.expanded for one in budgets}),
        bench=bench_groups(stated, known),
        budgets=result_groups(measured({**stated, "uncertainty": budget_document(budgets)})),
        residual_tables=residual_tables(solution.residuals),
        residual_plots=residual_plots(solution.residuals),
        diagnosis=Markup(diagnosis.section),
        noise=Markup(noise_section(noise)),
        conditions=[*condition_lines(campaigns, solution), *(bench or {}).items()],
        seating=_detectable_seating(solution.undetectable_tilts),
        not_observable=document.not_observable,
        warnings=document.warnings,
        unused_steps=document.unused_steps,
        correlations=correlations(solution),
        is_simulated=bool(known),
    )


def write_report(path: str | Path, report: CalibrationReport) -> None:
    """Write the report as one self-contained HTML file, replacing an older one in one step.

    Raise `CannotWrite` if the place cannot be written.
    """
    replace_file(Path(path), render(report).encode())


def render(report: CalibrationReport) -> str:
    """Return the report's HTML; equal reports give equal text."""
    return html_template("report.html").render(
        report=report, verdict_mark=VERDICT_MARK[report.verdict.word], limit_sigmas=f"{LIMIT_SIGMAS:g}"
    )


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


def _summary(campaigns: Sequence[Campaign], diagnosis: ReportedDiagnosis) -> Lines:
    """Return the first page's rows, in a customer's words: what was measured, the cause found, what to do."""
    measured = "; ".join(dict.fromkeys(map(procedure_name, campaigns)))
    rows = (
        ("Measured", f"{measured[0].upper()}{measured[1:]}."),
        ("Cause found", diagnosis.cause),
        ("What to do", diagnosis.advice),
    )
    return [row for row in rows if row[1]]


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


_AXIS_OFFSET = 0.22  # how far apart the three axes of a step stand


def residual_svg(triad: str, residuals: Sequence[StepResidual]) -> str:
    """Return the plot of a triad's residuals / sigma with lines at 2 and 4 sigma; empty if it has none."""
    chosen = [r for r in residuals if r.triad == triad]
    if not chosen:
        return ""
    ratio = np.array([normalised(r) for r in chosen])
    greatest = float(np.max(np.nan_to_num(np.abs(ratio))))

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        _limits(axes, max(5.0, 1.1 * greatest))
        for i, axis in enumerate(AXES):
            colour, marker = AXIS_STYLE[axis]
            at = np.arange(len(chosen)) + (i - 1) * _AXIS_OFFSET
            axes.vlines(at, 0, ratio[:, i], color=colour, linewidth=0.8, alpha=0.55)
            axes.plot(
                at, ratio[:, i], marker, color=colour, markersize=4.2, linestyle="none", label=f"{triad[0]}{axis}"
            )
        axes.set_xticks(np.arange(len(chosen)), [_tick(r) for r in chosen])
        axes.tick_params(axis="x", length=0)
        axes.set_xlim(-0.6, len(chosen) - 0.4)
        axes.set_xlabel(
            "position of a dwell"
            + (", axis of a turn" if any(r.kind == "turn" for r in chosen) else "")
            + (", m: a move" if any(r.kind == "move" for r in chosen) else "")
        )
        axes.set_ylabel("residual / \u03c3")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside upper right", ncols=3, handletextpad=0.1)

    steps = len(chosen)
    description = f"Residuals of the {triad} over their sigma, {steps} steps, greatest {greatest:.1f}"
    return draw_svg(f"residual-{triad}", description, (7.0, 2.35), draw)


def _limits(axes: Axes, greatest: float) -> None:
    axes.axhspan(-NOTICE_SIGMAS, NOTICE_SIGMAS, color=PALE, zorder=0, linewidth=0)
    axes.axhline(0, color=RULE, linewidth=0.7)
    for sigmas, dash in ((NOTICE_SIGMAS, (0, (4, 3))), (LIMIT_SIGMAS, "solid")):
        for side in (-1, 1):
            axes.axhline(side * sigmas, color=INK, linewidth=0.7, linestyle=dash, zorder=1)
        label = f"\u00b1{sigmas:g}\u03c3" + (" limit" if sigmas == LIMIT_SIGMAS else "")
        axes.annotate(
            label, (1.0, sigmas), (3, 0), axes.get_yaxis_transform(), "offset points", va="center", fontsize=7.5
        )
    axes.set_ylim(-greatest, greatest)


def _tick(residual: StepResidual) -> str:
    if residual.kind == "move":
        return "m"
    if residual.kind != "turn":
        return str(residual.position)
    name = residual.name.removesuffix(".csv").removesuffix(".mcap").removeprefix("turn_")
    return name.replace("_plus", "+").replace("_minus", "\u2212")


def residual_plots(residuals: Sequence[StepResidual]) -> list[tuple[str, Markup]]:
    """Return each triad that has residuals, and these as an ``<svg>`` element."""
    drawn = ((triad, residual_svg(triad, residuals)) for triad in TRIADS)
    return [(triad, Markup(svg)) for triad, svg in drawn if svg]
