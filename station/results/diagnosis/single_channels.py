"""Single channels of a triad that is not solved, as `diagnosis/1` and as lines."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from procedures.diagnosis.single_channels import SingleChannel, single_channels
from procedures.statistics.line_with_correlated_errors import CorrelatedLine
from procedures.units import DEG_H_PER_DEG_S, S_PER_H
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.solution_text import measured

NOT_KNOWN = "unknown: the recording is too short, or the counts are too coarse"


def channels_of(campaigns: Sequence[LoadedCampaign], solved: Sequence[str]) -> list[dict[str, Any]]:
    """Return what the live channels of triads that are not ``solved`` and have a dead one show by themselves."""
    counts = campaigns[0].tables.imu.output != "rate"
    return [_document(each, counts) for each in single_channels([one.campaign for one in campaigns], solved)]


def _document(found: SingleChannel, counts: bool) -> dict[str, Any]:
    unit = "count/s" if counts else "output"
    factor, noise_factor = 1.0, 1.0
    noise_unit = f"{unit} sqrt(s)"
    told: dict[str, Any] = {
        "channel": f"{found.triad} {found.axis}",
        "recording": found.recording,
        "seconds": found.seconds,
    }
    if found.scale is not None:
        scale, std = found.scale
        told["scale_factor"] = {"value": scale, "std": std, "unit": "count/deg" if counts else "output/(deg/s)"}
        factor, unit = DEG_H_PER_DEG_S / scale, "deg/h"
        noise_factor, noise_unit = S_PER_H**0.5 / abs(scale), "deg/sqrt(h)"
    told["mean"] = {"value": found.mean * factor, "unit": unit}
    if found.noise.value is not None:
        told["random_walk"] = {
            "value": found.noise.value * noise_factor, "low": found.noise.low * noise_factor,
            "high": found.noise.high * noise_factor, "unit": noise_unit,
        }  # fmt: skip
    told |= _line("drift", found.drift, factor, f"{unit}/h")
    told |= _line("by_temperature", found.warming, factor, f"{unit}/K")
    return told | {"temperature_moved_k": found.kelvin}


def _line(name: str, line: CorrelatedLine | None, factor: float, unit: str) -> dict[str, Any]:
    if line is None:
        return {}
    return {name: {"value": line.slope * factor, "std": line.std * abs(factor), "unit": unit}}


def channel_lines(channels: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield what single channels show, as text in 80 columns; +- is 1 sigma."""
    for each in channels:
        yield f"{each['channel']} alone, {each['seconds']:.0f} s of {each['recording']}"
        for key, name in (
            ("scale_factor", "scale factor"),
            ("drift", "drift"),
            ("by_temperature", "by temperature"),
        ):
            if key in each:
                yield f"   {name:<16}{measured(each[key]['value'], each[key]['std'])} {each[key]['unit']}"
        walk = each.get("random_walk")
        value = (
            f"{walk['value']:.3g} {walk['unit']}, 95 % {walk['low']:.3g} to {walk['high']:.3g}"
            if walk
            else NOT_KNOWN
        )
        yield f"   {'random walk':<16}{value}"
        if "drift" in each and "by_temperature" in each:
            moved = f"{each['temperature_moved_k']:.1f} K"
            yield f"   the temperature moved by {moved}: drift and temperature may be one and the same"
