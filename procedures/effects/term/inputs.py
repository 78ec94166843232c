"""What a term may name: of each sensor what it felt, put out and went through, at the nodes of every step.

A value is (n, 3), a column a sensor, or (n, 1) where it is the same for all, in the bases of
`procedures.effects.term.units`. ``_2`` and ``_3`` are the two other axes in turn: y and z of sensor x.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.excitation import REFERENCE_C, Excitation, without_gaps
from procedures.effects.temperature_history import since_begun, warming
from procedures.effects.term.units import Unit, parse_unit
from procedures.frames import AXES

AUXILIARY = "aux_"
MEASURED = {"accelerometer": "f", "gyroscope": "omega"}  # what a triad measures
Value = Callable[[Excitation, str], FloatArray]
Vector = Callable[[Excitation], FloatArray]


@dataclass(frozen=True, slots=True, eq=False)
class Input:
    """An input: ``value`` (n, 3) or (n, 1) in ``unit`` of an excitation and a triad; ``meaning`` in words.

    ``driver`` is what drives an effect that names it. ``is_of_campaign``: it is known while a campaign is solved,
    and not of a sample that comes later.
    """

    unit: str
    meaning: str
    value: Value
    driver: str = ""
    is_of_campaign: bool = False

    def in_bases(self, seen: Excitation, triad: str) -> FloatArray:
        """Return its value (n, 3) or (n, 1) in the bases; nan where it is not known."""
        found: FloatArray = self.value(seen, triad) * parse_unit(self.unit).size
        return found

    @property
    def of_unit(self) -> Unit:
        """Its unit."""
        return parse_unit(self.unit)


def _vector(
    name: str, unit: str, meaning: str, of: Callable[[Excitation], FloatArray]
) -> Iterator[tuple[str, Input]]:
    """Yield a vector's components: the sensor's own, the two others in turn, those along x, y, z, its length."""
    orders = {"": ("along the sensor", [0, 1, 2]), "_2": ("along the next axis", [1, 2, 0]),
              "_3": ("along the last axis", [2, 0, 1])}  # fmt: skip
    orders |= {f"_{axis}": (f"along {axis}", [i]) for i, axis in enumerate(AXES)}
    for suffix, (along, order) in orders.items():
        yield f"{name}{suffix}", Input(unit, f"{meaning} {along}", _in_order(of, order), meaning)
    yield f"{name}_norm", Input(unit, f"{meaning}, its length", lambda seen, triad: _length(of(seen)), meaning)


def _in_order(of: Callable[[Excitation], FloatArray], order: list[int]) -> Value:
    return lambda seen, triad: of(seen)[:, order]


def _length(vector: FloatArray) -> FloatArray:
    found: FloatArray = np.linalg.norm(vector, axis=1, keepdims=True)
    return found


def _one(of: Callable[[Excitation], FloatArray]) -> Value:
    return lambda seen, triad: of(seen)[:, None]


def _own(seen: Excitation, triad: str) -> FloatArray:
    return seen.f if triad == "accelerometer" else seen.omega


def _output(seen: Excitation, triad: str) -> FloatArray:
    return seen.accel_output if triad == "accelerometer" else seen.gyro_output


def _cosine(row: int) -> Value:
    """Return the direction cosines (n, 3) of the sensors' axes with East (0) or North (1)."""
    return lambda seen, triad: np.full(seen.f.shape, np.nan) if seen.C_sn is None else seen.C_sn[:, :, row]


INPUTS: Mapping[str, Input] = {
    **dict(_vector("f", "g", "specific force", lambda seen: seen.f)),
    **dict(_vector("omega", "deg/s", "rate", lambda seen: seen.omega)),
    **dict(_vector("B", "uT", "magnetic field", lambda seen: seen.magnetic)),
    "T": Input("K", "temperature above 25 degC", _one(lambda seen: seen.temperature - REFERENCE_C), "temperature"),
    "T_rate": Input("K/min", "rate of the temperature", _one(lambda seen: seen.temperature_rate), "temperature"),
    "t": Input("s", "device time", _one(lambda seen: seen.t), "time", is_of_campaign=True),
    "t_step": Input("s", "time since the step began", _one(lambda seen: seen.rest_s), "time at rest",
                    is_of_campaign=True),
    "f_before": Input("g", "specific force along the sensor in the step before", lambda seen, triad: seen.f_before,
                      "specific force", is_of_campaign=True),
    "north": Input("1", "cosine of the sensor's axis with North", _cosine(1), is_of_campaign=True),
    "east": Input("1", "cosine of the sensor's axis with East", _cosine(0), is_of_campaign=True),
}  # fmt: skip
CHANGING = 0.5  # of the largest output of a sensor, by which it must change to be more than a bias


def _changing(seen: Excitation, triad: str) -> FloatArray:
    output = _output(seen, triad)
    changes = np.ptp(output, axis=0) > CHANGING * np.max(np.abs(output), axis=0)
    return np.where(changes, output, 0.0)


def _rest(seen: Excitation) -> FloatArray:
    rests = np.array([step.kind in {"dwell", "rest"} for step in seen.steps])[seen.step]
    return np.where(rests, seen.rest_s, np.inf)


def _variance(seen: Excitation) -> FloatArray:
    return np.full(seen.f.shape, np.nan) if seen.vibration is None else seen.vibration


OF_CATALOGUE: Mapping[str, Mapping[str, Input]] = {
    triad: {
        "warming": Input("1", "1 while it grows warmer, -1 while it cools", _one(warming), "temperature"),
        "t_on": Input("s", "time since the recording began", _one(since_begun), "time", is_of_campaign=True),
        "t_rest": Input("s", "time since a rest began, infinite elsewhere", _one(_rest), "time at rest",
                        is_of_campaign=True),
        "out_changing": Input(unit, "what the sensor puts out, zero where it hardly changes", _changing, "input",
                              is_of_campaign=True),
        **{name: replace(one, is_of_campaign=True)
           for name, one in _vector("vibration", "g^2", "variance of the vibration", _variance)},
    }
    for triad, unit in (("accelerometer", "g"), ("gyroscope", "deg/s"))
}  # fmt: skip
"""What only laws of the catalogue name."""
OWN: Mapping[str, Mapping[str, Input]] = {
    triad: {
        "u": Input(unit, f"what the sensor measures: {quantity}", _own, "input"),
        "out": Input(unit, "what the sensor puts out, E u + D", _output, "input"),
    }
    for triad, unit, quantity in (("accelerometer", "g", "specific force"), ("gyroscope", "deg/s", "rate"))
}


def inputs_of(triad: str) -> Mapping[str, Input]:
    """Return the inputs of a triad's sensors by name; those of auxiliary channels in addition: `input_of`."""
    return {**OWN[triad], **INPUTS}


def input_of(name: str, triad: str) -> Input | None:
    """Return an input by its name, None where there is none; ``aux_NAME`` is an auxiliary channel."""
    if name.startswith(AUXILIARY) and name != AUXILIARY:
        return Input("unit", "an auxiliary channel", _channel(name.removeprefix(AUXILIARY)), "channel")
    return inputs_of(triad).get(name)


def known_input(name: str, triad: str) -> Input | None:
    """Return an input by its name, also one that only the catalogue has."""
    return OF_CATALOGUE[triad].get(name) or input_of(name, triad)


def _channel(name: str) -> Value:
    def value(seen: Excitation, triad: str) -> FloatArray:
        if name not in seen.auxiliary:
            return np.full((len(seen.f), 1), np.nan)
        return without_gaps(seen, seen.auxiliary[name])[:, None]

    return value
