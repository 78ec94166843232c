"""``tolerance/1`` as a table to read: ug, ppm, arcsec and mm."""

from collections.abc import Mapping, Sequence
from typing import Any

from procedures.tolerance.items import ITEMS
from procedures.units import ARCSEC_PER_RAD, PPM_PER_ONE, RAD_PER_ARCSEC, UG_PER_G
from station.results.tolerance.tolerance_study import ESTIMATORS

WHAT = {
    "p1_case": "P1's case",
    "worst_case_at_most": "worst, at most",
    "worst_case_reached": "worst, reached",
    "rms": "rms",
    "within_95_percent": "95 % within",
}


def tolerance_text(found: Mapping[str, Any]) -> str:
    """Return the summary that ``station fixtures tolerance`` prints."""
    side = found["side_mm"]
    lines = [f"{found['cube']}: side {side:g} mm; an item's angle is its tolerance over the side"]
    drawn = found["distribution"]
    how = {"any": "each face in any direction", "p1": "in the directions of P1 table 3"}[drawn["directions"]]
    lines += [
        "",
        f"error of the estimated bias [ug]; {found['cubes_drawn']} cubes, items {drawn['items']}, {how};",
    ]
    lines.append("  P1's case: every item at its limit, faces tilted as in P1 table 3; worst: in any directions")
    lines.append(f"  {'':30}{'x':>11}{'y':>11}{'z':>11}")
    for name, part in found["bias"].items():
        lines += [_row(f"{ESTIMATORS[name]}, {WHAT[key]}", part[key], UG_PER_G) for key in WHAT]
    scale, angle = found["scale_factor"], found["misalignment"]
    keys = ("worst_case_at_most", "within_95_percent")
    lines += [_row(f"scale factor [ppm], {WHAT[key]}", scale[key], PPM_PER_ONE) for key in keys]
    lines += [_row("misalignment [arcsec], 95 %", angle["within_95_percent"], ARCSEC_PER_RAD)]
    return "\n".join([*lines, *_allowed(found), *_gains(found["would_buy"])])


def _row(name: str, values: Sequence[float], per: float) -> str:
    return f"  {name:30}" + "".join(f"{value * per:11.4g}" for value in values)


def _allowed(found: Mapping[str, Any]) -> list[str]:
    if "allowed" not in found:
        return []
    wanted = found["wanted"]
    lines = [
        "",
        f"for a {ESTIMATORS[wanted['estimator']]} bias within {wanted['bias_g'] * UG_PER_G:.4g} ug in the "
        "worst case, tolerances of the cheapest cube [mm], cheapest relaxation first",
        f"  {'item':38}{'now':>9}{'allowed':>9}{'alone':>9}  {'change':8}{'saves':>8}",
    ]
    for one in found["allowed"]:
        alone = "none" if one["alone_mm"] is None else f"{one['alone_mm']:.4f}"
        lines.append(
            f"  {one['item'] + ' ' + ITEMS[one['item']]:38}{one['present_mm']:9.4f}{one['allowed_mm']:9.4f}"
            f"{alone:>9}  {one['change']:8}{one['saving']:8.1%}"
        )
    total = sum(one["saving"] for one in found["allowed"])
    lines.append(f"  {'all items':38}{'':29}{'saves' if total >= 0 else 'costs':8}{total:8.1%}")
    return [*lines, "  alone: what the item may be while all others stay as they are; cost = weight / tolerance"]


def _gains(gains: Sequence[Mapping[str, Any]]) -> list[str]:
    lines = ["", "what else would help: 1 sigma of the worst axis by the joint solve, K2 left out of it or open"]
    lines.append(f"  {'':46}{'bias':>9}{'bias,':>9}{'K2':>9}{'E':>9}")
    lines.append(f"  {'':46}{'ug':>9}{'K2 open':>9}{'ug/g2':>9}{'arcsec':>9}")
    for one in gains:
        sigmas = (one["bias_std_g"], one["bias_std_k2_open_g"], one["k2_std_g_per_g2"])
        cells = [sigma * UG_PER_G for sigma in sigmas] + [one["misalignment_std_rad"] / RAD_PER_ARCSEC]
        lines.append(f"  {one['with']:46}" + "".join(f"{cell:9.3g}" for cell in cells))
    return lines
