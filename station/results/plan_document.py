"""A planned campaign as `planned/1` and as text: minutes, steps, each sigma with the wanted and the usual.

Of a campaign in progress: its placements as a design has them, and what comes next in words.
"""

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fixtures_db.imu_models import UNITS
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord
from procedures.frames import AXES
from procedures.planning.campaign_design import TURNS, CampaignDesign, Placement, usual_design
from procedures.planning.design_sigmas import IN_PLACE, NAMES, TIMES_USUAL, DesignSigmas, WantedSigmas
from procedures.planning.identifiability import identifiable_effects
from procedures.planning.least_time import NextPlacement, PlannedCampaign
from procedures.planning.step_information import UnitNoise
from procedures.positions import ATTITUDES, face_of
from procedures.units import ARCSEC_PER_RAD, PPM_PER_ONE, S_PER_H, S_PER_MIN, UG_PER_G
from station.files.campaign_folder.campaign_reading import read_campaign
from station.results.parameters_by_name import title_of
from station.text import significant, table_lines

FORMAT = "planned/1"
PPM = "ppm"


def plan_document(
    found: PlannedCampaign, asked: WantedSigmas, sigmas: DesignSigmas, stated: dict[str, str]
) -> dict[str, Any]:
    """Return a plan; ``stated`` has where noise and hands' times are from, in words.

    Scale factors are in ppm, the rest as files have it.
    """
    hands, usual = sigmas.steps.hands, usual_design()
    return {
        "format": FORMAT,
        "minutes": round(found.design.minutes(hands), 2),
        "usual_minutes": round(usual.minutes(hands), 2),
        "steps": [_step(at, sigmas) for at in found.design.placements],
        "effects": effect_table(sigmas, found.design),
        "sigmas": sigma_table(found.sigmas, asked, sigmas.of(usual)),
        "noise": noise_table(sigmas.steps.noise) | {"source": stated["noise"]},
        "hands_s": asdict(hands) | {"source": stated["hands"]},
    }


def sigma_table(found: FloatArray, asked: WantedSigmas, usual: FloatArray) -> list[dict[str, Any]]:
    """Return a row for each parameter that a plan can do something about, of sigmas ``found``, ``usual`` (30,)."""
    rows = []
    for i, name in enumerate(NAMES):
        if IN_PLACE[i]:
            continue
        is_scale = ".scale_factor." in name
        times, unit = (PPM_PER_ONE, PPM) if is_scale else (1.0, UNITS[name][0])
        row: dict[str, Any] = {"parameter": name, "unit": unit}
        values = {"wanted": asked.sigma[i], "plan": found[i], "usual": usual[i]}
        rows.append(row | {key: float(times * value) for key, value in values.items() if np.isfinite(value)})
    return rows


def effect_table(sigmas: DesignSigmas, design: CampaignDesign) -> list[dict[str, Any]]:
    """Return which effects of the instrument a diagnosis identifies by a design and by the usual one, moves in."""
    identified = [
        {one.name: one for one in identifiable_effects(sigmas, each)}
        for each in (design, usual_design(moves=True))
    ]
    return [
        {"effect": name}
        | {
            key: {"is_told": one.is_identified, "not_apart": list(one.not_apart)}
            for key, of in zip(("plan", "usual"), identified, strict=True)
            if (one := of.get(name)) is not None
        }
        for name in dict.fromkeys(name for of in identified for name in of)
    ]


def not_met(document: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of a plan's sigmas that are above what is wanted."""
    return [row for row in document["sigmas"] if row.get("plan", np.inf) > row.get("wanted", np.inf)]


def given_up(document: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the rows that nobody asked for and that a plan leaves worse than `TIMES_USUAL` usual sigmas."""
    return [
        row
        for row in document["sigmas"]
        if "wanted" not in row
        and not row["parameter"].startswith("accelerometer.scale_factor")  # follows the site's gravity
        and row.get("plan", np.inf) > TIMES_USUAL * row.get("usual", np.inf)
    ]


def noise_table(noise: UnitNoise) -> dict[str, Any]:
    """Return a unit's noise by axis: ug/sqrt(Hz), deg/sqrt(h); the bias instability in deg/h."""
    return {
        "accelerometer_g_sqrt_s": dict(zip(AXES, noise.accel_white.tolist(), strict=True)),
        "gyroscope_deg_sqrt_h": dict(zip(AXES, (noise.gyro_white * np.sqrt(S_PER_H)).tolist(), strict=True)),
        "wander_deg_h": noise.instability * S_PER_H,
    }


def _step(at: Placement, sigmas: DesignSigmas) -> dict[str, Any]:
    if at.turn is not None:
        step = CampaignDesign((at,)).steps()[0]
        return {"kind": "turn", "name": step.name, "seconds": sigmas.steps.hands.turn}
    axes = ATTITUDES[at.position - 1]
    return {"kind": "dwell", "axes": axes, "up": face_of(at.position), "seconds": at.seconds}


SHOWN = {"g": (UG_PER_G, "ug"), "1": (ARCSEC_PER_RAD, "arcsec")}
DIGITS = 3


def plan_text(document: dict[str, Any]) -> str:
    """Return a summary of a `planned/1` document: minutes, steps, sigmas, what is out of reach."""
    dwells = [step for step in document["steps"] if step["kind"] == "dwell"]
    turns = len(document["steps"]) - len(dwells)
    lines = [
        f"{document['minutes']:.1f} min: {len(dwells)} placements, "
        f"{f'{turns} rotations' if turns else 'no rotations'}; the usual plan takes "
        f"{document['usual_minutes']:.1f} min",
        *[f"not reachable: {_missed(row)}" for row in not_met(document)],
        *[f"less accurate in return: {_lost(row)}" for row in given_up(document)],
        "",
        *_step_lines(document["steps"]),
        "",
        *table_lines([_row(row) for row in document["sigmas"]], "<>>><", ("u of", "target", "plan", "usual", "")),
        "",
        *table_lines([_effect(row) for row in document["effects"]], "<<<", ("diagnosis of", "plan", "usual")),
        "",
        f"noise: {document['noise']['source']}",
        f"hands: {document['hands_s']['source']}",
    ]
    return "\n".join(lines)


def _step_lines(steps: list[dict[str, Any]]) -> list[str]:
    rows = []
    for number, step in enumerate(steps, 1):
        up = step.get("up", "").replace("_", " ")
        rows.append((str(number), step.get("axes") or step["name"], up, f"{step['seconds']:.0f} s"))
    return table_lines(rows, "><<>", ("", "x y z point", "", "for"))


def _row(row: dict[str, Any]) -> tuple[str, ...]:
    times, unit = SHOWN.get(row["unit"], (1.0, row["unit"]))
    numbers = [significant(times * row[key], DIGITS) if key in row else "-" for key in ("wanted", "plan", "usual")]
    return (title_of(row["parameter"]), *numbers, unit)


def _effect(row: dict[str, Any]) -> tuple[str, ...]:
    return row["effect"], *(_identified(row.get(key)) for key in ("plan", "usual"))


def _identified(identified: dict[str, Any] | None) -> str:
    if identified is None or not identified["is_told"]:
        return "no"
    return f"yes, or {', or '.join(identified['not_apart'])}" if identified["not_apart"] else "yes"


def _missed(row: dict[str, Any]) -> str:
    name, wanted, plan, _, unit = _row(row)
    return f"{name} {wanted} {unit}; best possible {plan if plan != '-' else 'nothing'} {unit}"


def _lost(row: dict[str, Any]) -> str:
    name, _, plan, usual, unit = _row(row)
    return f"{name} {plan if plan != '-' else 'open'} {unit}, usually {usual}"


MOST_DIGITS = 6  # of two numbers that are nearly the same
NO_ATTITUDE_LEFT = "all attitudes are recorded, and the targets cannot be reached: solve with the steps done"


@dataclass(frozen=True, slots=True)
class SigmaSoFar:
    """How far a triad's parameter is by its worst sigma, and the ratio of that sigma to the one that is wanted.

    ``text`` is such as ``gyroscope bias 0.0130 of 0.0200 deg/h``.
    """

    text: str
    ratio: float


def placements_of(folder: Path) -> list[Placement]:
    """Return the dwells and turns of a campaign's folder in the order of their times; raise as `read_campaign`."""
    return [placement for _, placement in placements_in(read_campaign(folder).campaign)]


def placements_in(campaign: Campaign) -> list[tuple[str, Placement]]:
    """Return a campaign's dwells and turns by file, in the order of their times, with whether moves lead there."""
    numbers = {(step.axis, step.direction): i for i, step in enumerate(TURNS)}
    steps = [
        (each.turn_on, float(each.series.t[0]), each.name, Placement(each.position, _seconds(each)))
        for each in campaign.dwells
    ]
    for turn in campaign.turns:
        placement = Placement(turn.start_position, 0.0, numbers[turn.axis, turn.direction])
        steps.append((turn.turn_on, float(turn.series.t[0]), turn.name, placement))
    steps.sort(key=lambda step: step[:2])
    carried = {(move.before, move.after) for move in campaign.moves}
    before = [""] + [name for _, _, name, _ in steps]
    return [
        (name, replace(placement, is_carried=(before[i], name) in carried))
        for i, (_, _, name, placement) in enumerate(steps)
    ]


def _seconds(dwell: DwellRecord) -> float:
    return len(dwell.series) * dwell.series.period


def continued_text(found: NextPlacement, asked: WantedSigmas, whole: WantedSigmas) -> str:
    """Return how far each asked sigma is, how long it will take, and the next placement.

    ``whole`` is what is asked, and all else as well as it is to be solved: reported where it alone is not met.
    """
    so_far, worst = sigmas_so_far(found.sigmas, asked), float(whole.worst(found.sigmas))
    lines = [one.text for one in so_far]
    if worst > 1 and all(one.ratio <= 1 for one in so_far):
        lines.append(all_else(worst))
    if not found.is_reachable and found.placing is None:
        return "\n".join([*lines, NO_ATTITUDE_LEFT])
    if not found.is_reachable:
        lines.append("the targets cannot be reached with the remaining placements")
    elif found.placing is not None:
        lines.append(f"about {np.ceil(found.seconds / S_PER_MIN):.0f} min left")
    if found.placing is None:
        return "\n".join([*lines, "all targets are met: stop, or continue"])
    axes, up = ATTITUDES[found.placing.position - 1], face_of(found.placing.position).replace("_", " ")
    return "\n".join([*lines, f"next: {axes}, {up}, for {found.placing.seconds:.0f} s"])


def sigmas_so_far(sigmas: FloatArray, asked: WantedSigmas) -> list[SigmaSoFar]:
    """Return every asked triad and kind by its worst axis, of ``sigmas`` (30,)."""
    ratios, worst = asked.ratios(sigmas), dict[str, int]()
    for i, name in enumerate(NAMES):
        if np.isfinite(asked.sigma[i]):
            kind = name.rpartition(".")[0]
            worst[kind] = max(worst.get(kind, i), i, key=lambda j: float(ratios[j]))
    return [_so_far(kind, NAMES[i], float(sigmas[i]), float(asked.sigma[i])) for kind, i in worst.items()]


def _so_far(kind: str, name: str, now: float, wanted: float) -> SigmaSoFar:
    times, unit = (
        (PPM_PER_ONE, "ppm") if ".scale_factor" in name else SHOWN.get(UNITS[name][0], (1.0, UNITS[name][0]))
    )
    if not np.isfinite(now):
        text = f"{title_of(kind)} not yet known, target {significant(times * wanted, DIGITS)} {unit}"
    else:
        text = f"{title_of(kind)} {' of '.join(apart(times * now, times * wanted))} {unit}"
    return SigmaSoFar(text, now / wanted)


def apart(now: float, wanted: float) -> tuple[str, str]:
    """Return both numbers, of any unit, with as many digits as show that the first is larger, where it is."""
    for digits in range(DIGITS, MOST_DIGITS):
        both = significant(now, digits), significant(wanted, digits)
        if now <= wanted or both[0] != both[1]:
            return both
    return significant(now, MOST_DIGITS), significant(wanted, MOST_DIGITS)


def all_else(ratio: float) -> str:
    """Say how far that is which nobody limits, its worst sigma over `TIMES_USUAL` usual ones."""
    if not np.isfinite(ratio):
        return f"other parameters not yet known, target {TIMES_USUAL:g} times the usual uncertainty"
    return f"other parameters {' of '.join(apart(TIMES_USUAL * ratio, TIMES_USUAL))} times the usual uncertainty"
