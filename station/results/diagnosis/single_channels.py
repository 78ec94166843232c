"""Single channels of a triad that is not solved, as `diagnosis/2` and as lines."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from procedures.diagnosis.single_channels import SingleChannel, single_channels
from procedures.statistics.allan_deviation import NoiseTerm
from procedures.statistics.line_fits import CorrelatedLine
from procedures.units import DEG_H_PER_DEG_S, S_PER_H, UG_PER_G
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.solution_text import measured

NOT_KNOWN = "unknown: the recording is too short, or the counts are too coarse"


def channels_of(campaigns: Sequence[LoadedCampaign], solved: Sequence[str]) -> list[dict[str, Any]]:
    """Return what the live channels of triads that are not ``solved`` show by themselves."""
    counts, told = campaigns[0].tables.imu.output != "rate", campaigns[0].campaign.nominal_scale
    found = single_channels([one.campaign for one in campaigns], solved)
    return [_document(each, _unit_of(each, counts, told)) for each in found]


@dataclass(frozen=True, slots=True)
class _Unit:
    """In which unit a channel's outputs are told, and its noise, and what they are multiplied by."""

    name: str
    factor: float
    noise_name: str
    noise_factor: float


def _unit_of(found: SingleChannel, counts: bool, told: Mapping[str, float]) -> _Unit:
    """Return the unit by a gyroscope's own scale factor, else by the unit told, else the output itself."""
    scale = found.scale[0] if found.scale is not None else told.get(found.triad)
    if scale is None:
        name = "count/s" if counts else "output"
        return _Unit(name, 1.0, f"{name} sqrt(s)", 1.0)
    if found.triad == "gyroscope":
        return _Unit("deg/h", DEG_H_PER_DEG_S / scale, "deg/sqrt(h)", S_PER_H**0.5 / abs(scale))
    return _Unit("ug", UG_PER_G / scale, "ug/sqrt(Hz)", UG_PER_G / abs(scale))


def _document(found: SingleChannel, unit: _Unit) -> dict[str, Any]:
    told: dict[str, Any] = {
        "channel": f"{found.triad} {found.axis}",
        "recording": found.recording,
        "seconds": found.seconds,
    }
    if found.scale is not None:
        of_scale = "count/deg" if found.is_count else "output/(deg/s)"
        told["scale_factor"] = {"value": found.scale[0], "std": found.scale[1], "unit": of_scale}
    told["mean"] = {"value": found.mean * unit.factor, "unit": unit.name}
    told |= _term("random_walk", found.noise, unit.noise_factor, unit.noise_name)
    told |= _term("bias_instability", found.instability, abs(unit.factor), unit.name)
    told |= _line("drift", found.drift, unit.factor, f"{unit.name}/h")
    told |= _line("by_temperature", found.warming, unit.factor, f"{unit.name}/K")
    return told | {"temperature_moved_k": found.kelvin}


def _term(name: str, term: NoiseTerm, factor: float, unit: str) -> dict[str, Any]:
    if term.value is None:
        return {}
    sizes = {"value": term.value, "low": term.low, "high": term.high}
    return {name: {**{key: size * factor for key, size in sizes.items()}, "unit": unit}}


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
        yield f"   {'random walk':<16}{_between(each.get('random_walk')) or NOT_KNOWN}"
        if flicker := _between(each.get("bias_instability")):
            yield f"   {'instability':<16}{flicker}"
        if "drift" in each and "by_temperature" in each:
            moved = f"{each['temperature_moved_k']:.1f} K"
            yield f"   the temperature changed by {moved}: drift and temperature cannot be separated"


def _between(term: Mapping[str, Any] | None) -> str:
    if term is None:
        return ""
    return f"{term['value']:.3g} {term['unit']}, 95 % {term['low']:.3g} to {term['high']:.3g}"
