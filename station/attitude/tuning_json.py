"""A tuning as JSON (`tuning/1`) and as people read it: the curve, what was chosen, what it is worth."""

from typing import Any

import numpy as np

from procedures.attitude.gain_tuning import GainTuning

FORMAT = "tuning/1"
BAR_WIDTH = 40  # characters


def tuning_document(tuning: GainTuning, aid: str, by_tau: bool) -> dict[str, Any]:
    """Return a tuning as `tuning/1`, JSON-ready."""
    curve = []
    for gains, rms, folds in zip(tuning.candidates, tuning.rms, tuning.by_fold, strict=True):
        point = {"k1": gains.k1, "k2": gains.k2, "rms_deg": _deg(rms), "by_stretch_deg": [_deg(x) for x in folds]}
        curve.append({"tau_s": 2 / gains.k1} | point if by_tau else point)
    best = {name: curve[tuning.best][name] for name in ("tau_s", "k1", "k2") if name in curve[tuning.best]}
    warnings = ["the best value is at the end of the grid"] if tuning.at_edge else []
    return {
        "format": FORMAT, "aid": aid, "rows": tuning.rows, "chosen": best,
        "rms_deg": _deg(tuning.rms[tuning.best]), "held_out_rms_deg": _deg(tuning.held_out),
        "chosen_without_stretch": [curve[i].get("tau_s", [curve[i]["k1"], curve[i]["k2"]]) for i in tuning.picked],
        "curve": curve, "warnings": warnings,
    }  # fmt: skip


def tuning_text(document: dict[str, Any]) -> str:
    """Return the curve with a bar per point, and what was chosen."""
    curve = document["curve"]
    least, most = (f([point["rms_deg"] for point in curve]) for f in (min, max))
    lines = [f"error against truth, aid {document['aid']}, {document['rows']} rows"]
    for point in curve:
        name = (
            f"tau {point['tau_s']:7.3g} s" if "tau_s" in point else f"K1 {point['k1']:7.4f} K2 {point['k2']:7.5f}"
        )
        share = np.log(point["rms_deg"] / least) / np.log(most / least) if most > least else 0.0
        mark = " <- least" if point["rms_deg"] == least else ""
        lines.append(f"{name}  {point['rms_deg']:8.4f} deg {'#' * (1 + round(share * (BAR_WIDTH - 1)))}{mark}")
    chosen = document["chosen"]
    option = (
        f"--tau {chosen['tau_s']:.4g}" if "tau_s" in chosen else f"--k1 {chosen['k1']:.4g} --k2 {chosen['k2']:.4g}"
    )
    lines.append(f"chosen: {option}; on held-out stretches {document['held_out_rms_deg']:.4f} deg rms")
    return "\n".join([*lines, *(f"warning: {warning}" for warning in document["warnings"])])


def _deg(angle: float) -> float:
    return float(np.degrees(angle))
