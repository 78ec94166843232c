"""A planned campaign as `planned/1` and as text: minutes, steps, each sigma beside the wanted and the usual."""

from dataclasses import asdict
from typing import Any

import numpy as np

from fixtures_db.imu_models import UNITS
from procedures.arrays import FloatArray
from procedures.frames import ATTITUDES, AXES, face_of
from procedures.planning.campaign_design import CampaignDesign, Placement, usual_design
from procedures.planning.design_sigmas import IN_PLACE, NAMES, TIMES_USUAL, DesignSigmas, WantedSigmas
from procedures.planning.identifiability import identifiable_effects
from procedures.planning.least_time import PlannedCampaign
from procedures.planning.step_information import UnitNoise
from procedures.units import ARCSEC_PER_RAD, PPM_PER_ONE, S_PER_H, UG_PER_G
from station.results.parameters_by_name import title_of
from station.text import significant, table_lines

FORMAT = "planned/1"
PPM = "ppm"


def plan_document(
    found: PlannedCampaign, asked: WantedSigmas, sigmas: DesignSigmas, said: dict[str, str]
) -> dict[str, Any]:
    """Return a plan; ``said`` has where noise and hands' times are from, in words.

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
        "noise": noise_table(sigmas.steps.noise) | {"source": said["noise"]},
        "hands_s": asdict(hands) | {"source": said["hands"]},
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
    """Return which effects of the instrument a diagnosis could tell by a design and by the usual one, moves in."""
    identified = [
        {one.name: one for one in identifiable_effects(sigmas, each)}
        for each in (design, usual_design(moves=True))
    ]
    return [
        {"effect": name}
        | {
            key: {"is_told": one.is_told, "not_apart": list(one.not_apart)}
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
    """Return a unit's noise by axis: ug/sqrt(Hz), deg/sqrt(h); the wander in deg/h."""
    return {
        "accelerometer_g_sqrt_s": dict(zip(AXES, noise.accel_white.tolist(), strict=True)),
        "gyroscope_deg_sqrt_h": dict(zip(AXES, (noise.gyro_white * np.sqrt(S_PER_H)).tolist(), strict=True)),
        "wander_deg_h": noise.wander * S_PER_H,
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
