"""What an effect is: a physical cause, its equation, and the columns by which it shows in the sensors' output."""

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.excitation import STEP, Columns, Excitation
from procedures.effects.term.law import Law

Kind = Literal["instrument", "bench", "procedure"]
MeasurementName = Literal[
    "repeat", "free_positions", "other_speeds", "two_speeds", "heating", "warming_campaign", "other_order",
    "steady_room", "other_field", "after_flips", "channel_moved", "again", "twice", "longer", "more_revolutions",
    "certificate", "remounted", "survey", "reference_time",
]  # fmt: skip
INSTRUMENT = ("accelerometer", "gyroscope")
BENCH = ("slab", "fixture", "site")
OF_CAMPAIGN = "specific to the campaign; one sample does not determine it"


def no_columns(excitation: Excitation) -> Sequence[Columns]:
    """Return none: of an effect that is found otherwise, as it is not small or averages out of every mean."""
    return ()


@dataclass(frozen=True, slots=True, eq=False)
class Effect:
    """A physical cause that a calibration's model may lack.

    ``plausible`` is 1 sigma of what its coefficients may be, in ``unit``. ``columns`` returns every way in which
    it may have acted in a campaign, none where nothing excites it. ``separate_by`` is the measurement that would
    tell it from what looks alike. ``added`` returns, for coefficients (k,) of the first of ``columns``, what is
    added (n, 3) and its change with them (n, 3, k), where the effect is not linear. ``shown`` returns coefficients
    (k,) in ``unit`` and their 1 sigma for those that are fitted, where the two differ, and ``fitted`` its inverse.
    ``is_scatter``: its coefficients, one a step, are draws of one variance, which is what is found.
    ``at`` returns one of its ways at another excitation, at the time constant and orders that the way has, where
    these are fitted; ``ranges`` bound what is not linear. ``separate_by_certified`` stands for ``separate_by``
    where the cube has a certificate already. ``is_loss``: its coefficients are above zero, or it is another.
    ``is_turn``: it turns all that is seen, by as much as its columns say, which are for small angles alone.
    ``driver`` is what it follows: "temperature", "channel", "time at rest" ...; of a law what its `Input` says.
    ``next_measurement`` is what separates it, "" where its driver determines that.
    ``multiplies_output``: it multiplies all that is put out, other effects included. ``same_at_rest`` names the
    effect that does the same while nothing but the driver changes. ``is_held_at_prior``: a campaign says no more
    of it than its prior does. ``covered_by`` names what stands for it where that is in the model.
    ``carried_with`` is what other campaigns must share for it to act in them: cube or unit, "" of the instrument.
    ``is_bench_parameter``: every model of a bench holds it, as a parameter with its prior; it is no cause.
    ``laws`` are its equations where the inputs of a sensor determine it, from which ``columns``, ``at`` and
    ``physics`` are made: `effect_of`. ``meaning`` is what it is in a phrase, ``of_shape`` the same of a shape.
    ``about`` is what it looks like and why its plausible size is what it is. ``not_corrected`` says why it is not
    taken out of samples; empty if it is.
    """

    name: str
    unit: str = ""  # this and what follows have defaults so that a test, no import, tells what an effect lacks
    physics: str = ""
    source: str = ""
    plausible: float = 0.0
    columns: Callable[[Excitation], Sequence[Columns]] = no_columns
    separate_by: str = ""
    added: Callable[[Excitation, FloatArray], tuple[FloatArray, FloatArray]] | None = None
    shown: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]] | None = None
    fitted: Callable[[FloatArray], FloatArray] | None = None
    separate_by_certified: str = ""
    is_loss: bool = False
    is_turn: bool = False
    is_bench_parameter: bool = False
    driver: str = ""
    next_measurement: MeasurementName | Literal[""] = ""
    multiplies_output: bool = False
    same_at_rest: str = ""
    is_held_at_prior: bool = False
    covered_by: str = ""
    carried_with: str = ""
    is_scatter: bool = False
    at: Callable[[Excitation, Columns], Columns] | None = None
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    laws: tuple[Law, ...] = ()
    meaning: str = ""
    of_shape: Mapping[str, str] = field(default_factory=dict)
    about: str = ""
    not_corrected: str = OF_CAMPAIGN

    def plausible_of(self, columns: Columns) -> FloatArray:
        """Return 1 sigma (k,) of what the fitted coefficients of one of its ways may be."""
        return np.array(columns.plausible or (self.plausible,) * len(columns.coefficients))

    @property
    def triad(self) -> str:
        """The triad that it acts on, "" of bench and procedure."""
        owner = self.name.partition(".")[0]
        return owner if owner in INSTRUMENT else ""

    def title(self, shape: str = "") -> str:
        """Return what it is in a phrase, which names its triad."""
        meaning = self.of_shape.get(shape, self.meaning)
        return meaning if self.triad in meaning else f"{meaning}, {self.triad}"

    @property
    def kind(self) -> Kind:
        """What it says something about: the instrument, the bench, or how the campaign was carried out."""
        owner = self.name.partition(".")[0]
        return "instrument" if self.triad else "bench" if owner in BENCH else "procedure"

    @property
    def is_of_steady_temperature(self) -> bool:
        """Say whether it depends on the temperature also while nothing changes, as a temperature coefficient."""
        return any(law.is_of_steady_temperature for law in self.laws)

    def law(self, shape: str = "") -> Law | None:
        """Return the equation of a shape, None where it has none."""
        return next((law for law in self.laws if law.shape == shape), None)


def effect_of(
    name: str, *laws: Law, unit: str, plausible: float,
    starts: Callable[[Excitation], Iterable[Columns]] | None = None, **about: Any,
) -> Effect:  # fmt: skip
    """Return an effect with columns of its laws; ``starts`` are the ways a search begins with, not yet columns.

    Laws take the triad from ``name``, and where they have none of their own, ``unit`` and ``plausible``.
    """
    triad = name.partition(".")[0]
    filled: dict[str, Any] = {"name": name.partition(".")[2], "triad": triad}
    own = {
        law.shape: replace(law, unit=law.unit or unit, plausible=law.plausible or plausible, **filled)
        for law in laws
    }

    def at(seen: Excitation, way: Columns) -> Columns:
        law = own[way.shape]
        return law.at(seen, replace(way, unit="" if law.unit == unit else law.unit))

    def columns(seen: Excitation) -> list[Columns]:
        begin = itertools.chain(*(law.starts(seen) for law in own.values())) if starts is None else starts(seen)
        return [at(seen, way) for way in begin]

    is_fitted = any(law.parameters or law.is_polynomial for law in laws)
    made: dict[str, Any] = {
        "columns": columns, "at": at if is_fitted else None,
        "physics": ", or ".join(dict.fromkeys(law.equation for law in own.values())),
        "driver": next(law.driver for law in own.values()),
        "multiplies_output": all("out" in law.inputs for law in laws),
        "ranges": {key: ends for law in laws for key, ends in law.ranges.items()},
        "not_corrected": OF_CAMPAIGN if any(law.looks_back for law in own.values()) else "",
    }  # fmt: skip
    return Effect(name=name, unit=unit, plausible=plausible, laws=tuple(own.values()), **{**made, **about})


def twins(name: str, *laws: Law, **about: Any) -> tuple[Effect, Effect]:
    """Return the effect of the accelerometers and that of the gyroscopes; where they differ, a pair is given."""
    accelerometer, gyroscope = (
        effect_of(f"{triad}.{name}", *laws, **{
            key: value[i] if isinstance(value, tuple) else value for key, value in about.items()
        })
        for i, triad in enumerate(INSTRUMENT)
    )  # fmt: skip
    return accelerometer, gyroscope


def with_slope(effect: Effect, seen: Excitation, way: Columns, c: FloatArray) -> Columns:
    """Return a way whose last columns are slopes by logarithms of what is not linear, at coefficients ``c`` (k,).

    These are in the effect's unit, such as g/K or deg/h/K.
    """
    first = len(c) - len(way.nonlinear)
    if effect.at is None or not way.nonlinear or not np.any(c[:first]):
        return way
    accel, gyro = ([] if part is None else [part[:, :, :first]] for part in (way.accel, way.gyro))
    for name, value in way.nonlinear.items():
        less, more = (
            effect.at(seen, replace(way, nonlinear={**way.nonlinear, name: value * float(np.exp(step))}))
            for step in (-STEP, STEP)
        )
        for found, low, high in ((accel, less.accel, more.accel), (gyro, less.gyro, more.gyro)):
            if low is not None and high is not None:
                slope: FloatArray = (high - low)[:, :, :first] @ c[:first] / (2 * STEP)
                found.append(slope[:, :, None])
    joined = [np.concatenate(parts, axis=2) if parts else None for parts in (accel, gyro)]
    return replace(way, accel=joined[0], gyro=joined[1])
