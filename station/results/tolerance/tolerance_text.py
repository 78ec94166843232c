"""``tolerance/1`` as a table to read: ug, ppm, arcsec and mm."""

from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import Any

from procedures.tolerance.drawing_items import ITEMS
from procedures.units import ARCSEC_PER_RAD, DEG_H_PER_RAD_S, PPM_PER_ONE, RAD_PER_ARCSEC, UG_PER_G
from station.results.tolerance.tolerance_study import ESTIMATORS
from station.text import WIDTH, table_lines

ERROR_TITLES = {
    "p1_case": "paper's case",
    "worst_case_at_most": "worst, at most",
    "worst_case_reached": "worst, reached",
    "rms": "rms",
    "within_95_percent": "95 % within",
}

SET_ASIDE_NAMES = {
    "accelerometer.bias_12_position": ("12-position bias", UG_PER_G, "ug"),
    "accelerometer.bias_two_direction": ("two-direction bias", UG_PER_G, "ug"),
    "accelerometer.bias": ("joint bias", UG_PER_G, "ug"),
    "accelerometer.scale_factor": ("scale factor", PPM_PER_ONE, "ppm"),
    "accelerometer.misalignment": ("misalignment", ARCSEC_PER_RAD, "arcsec"),
    "gyroscope.bias": ("gyro bias", DEG_H_PER_RAD_S, "deg/h"),
    "gyroscope.scale_factor": ("gyro scale factor", PPM_PER_ONE, "ppm"),
    "gyroscope.misalignment": ("gyro misalignment", ARCSEC_PER_RAD, "arcsec"),
}


def tolerance_text(found: Mapping[str, Any]) -> str:
    """Return the summary that ``station fixtures tolerance`` prints."""
    drawn = found["distribution"]
    how = {"any": "each face in any direction", "p1": "in the directions of table 3"}[drawn["directions"]]
    lines = [
        f"{found['cube']}: side {found['side_mm']:g} mm; an item's angle is its tolerance over the side",
        "",
        f"error of the estimated bias [ug]; {found['cubes_drawn']} cubes, items {drawn['items']},",
        f"{how}; worst: in any directions",
        "paper's case: every item at its limit, faces as in table 3 of Yao, Hu, He 2018",
    ]
    return "\n".join([*lines, *_errors(found), *_allowed(found), *_gains(found["would_buy"]), *_set_aside(found)])


def _errors(found: Mapping[str, Any]) -> list[str]:
    rows = [
        (f"{ESTIMATORS[name]}, {ERROR_TITLES[key]}", part[key], UG_PER_G)
        for name, part in found["bias"].items()
        for key in ERROR_TITLES
    ]
    for key in ("worst_case_at_most", "within_95_percent"):
        rows.append((f"scale factor [ppm], {ERROR_TITLES[key]}", found["scale_factor"][key], PPM_PER_ONE))
    rows.append(("misalignment [arcsec], 95 %", found["misalignment"]["within_95_percent"], ARCSEC_PER_RAD))
    cells = ([name, *(f"{value * per:.4g}" for value in values)] for name, values, per in rows)
    return table_lines(cells, "<>>>", ("", "x", "y", "z"))


def _allowed(found: Mapping[str, Any]) -> list[str]:
    if "allowed" not in found:
        return []
    wanted = found["wanted"]
    rows = [
        (
            f"{one['item']} {ITEMS[one['item']]}",
            f"{one['present_mm']:.4f}",
            f"{one['allowed_mm']:.4f}",
            "none" if one["alone_mm"] is None else f"{one['alone_mm']:.4f}",
            one["change"],
            f"{one['saving']:.1%}",
        )
        for one in found["allowed"]
    ]
    total = sum(one["saving"] for one in found["allowed"])
    rows.append(("all items", "", "", "", "saves" if total >= 0 else "costs", f"{total:.1%}"))
    return [
        "",
        f"for a {ESTIMATORS[wanted['estimator']]} bias within {wanted['bias_g'] * UG_PER_G:.4g} ug at the worst,",
        "tolerances of the cheapest cube [mm], cheapest relaxation first",
        *table_lines(rows, "<>>><>", ("item", "now", "allowed", "alone", "change", "saves")),
        "  alone: its allowed value while all others stay unchanged; cost = weight / tolerance",
    ]


def _gains(gains: Sequence[Mapping[str, Any]]) -> list[str]:
    rows = []
    for one in gains:
        sigmas = (one["bias_std_g"], one["bias_std_k2_open_g"], one["k2_std_g_per_g2"])
        cells = [sigma * UG_PER_G for sigma in sigmas] + [one["misalignment_std_rad"] / RAD_PER_ARCSEC]
        rows.append([one["with"], *(f"{cell:.3g}" for cell in cells)])
    return [
        "",
        "other improvements: standard uncertainty of the worst axis, joint solution,",
        "K2 known or unknown",
        *table_lines(rows, "<>>>>", ("", "bias\nug", "bias, K2\nunknown, ug", "K2\nug/g2", "E\narcsec")),
    ]


def _set_aside(found: Mapping[str, Any]) -> list[str]:
    lines = ["", "items that the paper does not treat, each alone: standard uncertainty of the worst axis"]
    items = [(f"{one['what']}, {one['size']:g} {one['unit']}", one["std"]) for one in found["set_aside"]]
    for what, std in [*items, ("all of them together", found["set_aside_together"])]:
        lines += [f"  {what}", *wrap(_words(std), WIDTH, initial_indent="      ", subsequent_indent="      ")]
    return lines


def _words(std: Mapping[str, Sequence[float]]) -> str:
    told = ((SET_ASIDE_NAMES[name], max(sigma)) for name, sigma in std.items())
    return ", ".join(f"{name} {sigma * per:.2g} {unit}" for (name, per, unit), sigma in told)
