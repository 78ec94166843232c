"""Error terms of a `calibration/1` as they are corrected: by their law, of the catalogue as of a user.

A term is written in the calibration's units: g, deg/s, K from 25 degC, K/min, uT, with every other number in its
coefficient. A term whose form `settling_kernels` has goes into its arrays (`compiled`); others are computed around
it. The inputs are those of `procedures.effects.term.inputs`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects import CATALOGUE
from procedures.effects.effect import OF_CAMPAIGN, Effect
from procedures.effects.term.dimensions import COEFFICIENT
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation, calls, names, parse
from procedures.effects.term.inputs import AUXILIARY, MEASURED
from procedures.effects.term.law import MAX_ORDER, Law
from procedures.effects.term.values import evaluated
from procedures.frames import AXES
from station.calibrated.correction_inputs import DIRECTION, RATE, WARMTH, Backlash, Signal, Surroundings, Triad
from station.errors import DataRefused
from station.files.effect_file import EffectFile, stored_effect

SIGNALS = {"T": WARMTH, "T_rate": RATE, "warming": DIRECTION}
PAIRS = ((0, 1), (0, 2), (1, 2))


@dataclass(frozen=True, slots=True)
class Slot:
    """Where `CompiledEffects` has a term: an array, the row or order in it, and the signal of a polynomial."""

    array: str
    at: int
    signal: Signal | None = None


def _forms(triad: str) -> dict[Node, Slot]:
    """Return the slots of terms by their form; those of `settling_kernels._of_input` in its order."""
    of_input = ("abs(u)", "u**2", "u * abs(u)", "u**3", "u * sine(c * u**2)")
    own = MEASURED[triad]
    texts = {text: Slot("powers", row) for row, text in enumerate(of_input)}
    texts |= {f"{own}_{AXES[i]} * {own}_{AXES[j]}": Slot("cross", column) for column, (i, j) in enumerate(PAIRS)}
    texts |= {f"B_{axis}": Slot("magnetic", column) for column, axis in enumerate(AXES)}
    if triad == "gyroscope":  # corrected after the accelerometers
        texts |= {f"f_{axis}": Slot("matrix", column) for column, axis in enumerate(AXES)}
    return {parse(text): slot for text, slot in texts.items()}


FORMS = {triad: _forms(triad) for triad in MEASURED}
ROWS = 5  # of powers


def slot_of(term: Node, triad: str) -> Slot | None:
    """Return where the kernel has a term, None where it has none of that form."""
    if (found := FORMS[triad].get(term)) is not None:
        return found
    array, order = "bias", 1
    match term:
        case Operation(sign="*", left=left, right=Name(name="out")):
            array, term = "scale", left
    match term:
        case Operation(sign="**", left=left, right=Number(value=value)) if value in range(2, MAX_ORDER + 1):
            order, term = int(value), left
    signal = _signal(term)
    return None if signal is None else Slot(array, order - 1, signal)


def _signal(term: Node) -> Signal | None:
    match term:
        case Name(name=name):
            return SIGNALS.get(name)
        case Call(name="lag", arguments=(Name(name="T"), Number(value=tau))):
            return tau
        case Call(name="backlash", arguments=(Name(name="T"), Number(value=width))):
            return Backlash(width)
    return None


@dataclass(frozen=True, slots=True, eq=False)
class AppliedEffect:
    """What an effect adds to a triad's output [g], [deg/s]: ``coefficients`` (3, m), a row a sensor, times terms.

    A term with ``c`` in it has its coefficient there. ``std`` (3, m) is their standard uncertainty, ``entry``
    where it stands in the calibration, ``slots`` where the kernel has its terms.
    """

    name: str
    triad: str
    coefficients: FloatArray
    std: FloatArray
    terms: tuple[Node, ...]
    entry: Mapping[str, Any]
    slots: tuple[Slot | None, ...]

    @property
    def is_compiled(self) -> bool:
        """Say whether the kernel has all of its terms."""
        return None not in self.slots

    @property
    def inputs(self) -> frozenset[str]:
        """The names in its terms."""
        return frozenset(each.name for term in self.terms for each in names(term))

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The lags and backlashes by which it follows the temperature."""
        found = (_signal(each) for term in self.terms for each in calls(term))
        return tuple(dict.fromkeys(signal for signal in found if signal is not None))

    @property
    def lags(self) -> tuple[float, ...]:
        """The time constants [s] of its lags."""
        return tuple(tau for tau in self.signals if isinstance(tau, float))

    def needs(self, around: Surroundings, triads: set[str]) -> str:
        """Return what it lacks in the surroundings of output of some triads, empty if it lacks nothing."""
        is_known = all(_is_known(name, around, triads) for name in self.inputs) and all(
            np.isfinite(around.followed[signal]).any() for signal in self.signals
        )
        return "" if is_known or self.triad not in triads else "the quantity that it depends on was not recorded"


def _is_known(name: str, around: Surroundings, triads: set[str]) -> bool:
    """Say whether an input of a term is known at any sample."""
    word = name.partition("_")[0]
    if word == "aux":
        value = around.auxiliary.get(name.removeprefix(AUXILIARY))
        return value is not None and bool(np.isfinite(value).any())
    if word == "B":
        return around.magnetic is not None and bool(np.isfinite(around.magnetic).any())
    if name in SIGNALS:
        return bool(np.isfinite(around.followed[SIGNALS[name]]).any())
    of_triad = {vector: triad for triad, vector in MEASURED.items()}
    return of_triad.get(word, next(iter(triads))) in triads


def applied_effect(entry: Mapping[str, Any]) -> AppliedEffect | str:
    """Return an effect of a `calibration/1` as it is corrected, or why it never is; raises as `own_effect`."""
    effect = effect_of_entry(entry)
    if effect is None:
        return "not in this program's catalogue"
    law = effect.law(str(entry.get("shape", "")))
    if effect.not_corrected or law is None:
        return effect.not_corrected or OF_CAMPAIGN
    values, stds = (
        {key: float(one.get(what) or 0.0) for key, one in entry["coefficients"].items()}
        for what in ("value", "std")
    )
    if lacking := [name for name in law.parameters if name not in values]:
        return f"no value of {lacking[0]}"
    table, std = law.table(values), law.table({key: stds[key] for key in values})
    if effect.fitted is not None:
        std = effect.fitted(abs(table) + std) - effect.fitted(abs(table))
        table = effect.fitted(table)
    per, terms = law.plain(values, table.shape[1])
    slots = tuple(slot_of(term, law.triad) for term in terms)
    one = AppliedEffect(effect.name, law.triad, per * table, abs(per) * std, terms, entry, slots)
    if not all(tau > 0 for tau in one.lags):
        return "a time constant that is not above zero"
    is_wide = all(each.half_width_k > 0 for each in one.signals if isinstance(each, Backlash))
    return one if is_wide else "a backlash that is not above zero"


def effect_of_entry(entry: Mapping[str, Any]) -> Effect | None:
    """Return the effect of an entry, None of one that the catalogue does not have; raises as `own_effect`."""
    return own_effect(entry).effect if "definition" in entry else CATALOGUE.get(str(entry["name"]))


def law_of_entry(entry: Mapping[str, Any]) -> Law | None:
    """Return the equation of an entry, None where there is none; raises as `own_effect`."""
    effect = effect_of_entry(entry)
    return None if effect is None else effect.law(str(entry.get("shape", "")))


def own_effect(entry: Mapping[str, Any]) -> EffectFile:
    """Return the `effect/1` of an entry that has one.

    Raise `DataRefused` if it is not what was stored, or a parameter of its term has no value.
    """
    name = str(entry["name"])
    found = stored_effect(str(entry["definition"]), str(entry.get("sha256", "")), name)
    if entry.get("unit", found.term.unit) != found.term.unit:
        raise DataRefused(f"effects.{name}", None, f"unit {entry['unit']!r}", f"{found.term.unit!r}, its term's")
    for parameter in found.term.parameters:
        if parameter not in entry.get("coefficients", {}):
            expected = "a value of every parameter of its term"
            raise DataRefused(f"effects.{name}", None, f"no value of {parameter}", expected, "solve it again")
    return found


@dataclass(frozen=True, slots=True, eq=False)
class CompiledEffects:
    """What a triad's effects add; ``bias`` and ``scale`` (signals, 3, orders) are polynomials of ``signals``.

    ``matrix`` (3, 3) [deg/s] is of the specific force in g, ``magnetic`` (3, 3) [deg/s] of the field in uT,
    ``powers`` (5, 3) and ``cross`` (3, 3) are of the triad's own input.
    """

    signals: tuple[Signal, ...]
    bias: FloatArray
    scale: FloatArray
    matrix: FloatArray
    magnetic: FloatArray
    powers: FloatArray
    cross: FloatArray


@lru_cache(maxsize=64)  # a stream asks for the same with every block
def compiled(effects: tuple[AppliedEffect, ...], triad: str) -> CompiledEffects:
    """Return what the effects of a triad add together; all are compiled."""
    own = [
        (slot, column)
        for one in effects
        for slot, column in zip(one.slots, one.coefficients.T, strict=True)
        if one.triad == triad and slot is not None
    ]
    signals = tuple(dict.fromkeys(slot.signal for slot, _ in own if slot.signal is not None))
    shape, square = (len(signals), len(AXES), MAX_ORDER), (3, 3)
    found = CompiledEffects(signals, *map(np.zeros, (shape, shape, square, square, (ROWS, 3), square)))
    for slot, column in own:
        into = getattr(found, slot.array)
        if slot.signal is not None:
            into[signals.index(slot.signal), :, slot.at] += column
        elif slot.array == "powers":
            into[slot.at] += column
        else:
            into[:, slot.at] += column
    return replace(found, bias=_without_zeros(found.bias), scale=_without_zeros(found.scale))


def _without_zeros(polynomials: FloatArray) -> FloatArray:
    """Return polynomials without the highest orders that none of them has."""
    used = np.flatnonzero(polynomials.any(axis=(0, 1)))
    return np.ascontiguousarray(polynomials[:, :, : used[-1] + 1 if len(used) else 0])


@dataclass(frozen=True, slots=True, eq=False)
class SampleInputs:
    """What terms are computed from at n samples, by name: vectors (n, 3), what all sensors share (n, 1).

    ``out`` (n, 3) is by triad what it puts out, E u + D; ``followed`` (n, 1) are lags by their time constant [s]
    and branches by their `Backlash`.
    """

    known: Mapping[str, FloatArray]
    out: Mapping[str, FloatArray]
    followed: Mapping[Signal, FloatArray]

    @classmethod
    def of(
        cls, triads: Mapping[str, Triad], u: Mapping[str, FloatArray], around: Surroundings, n: int
    ) -> "SampleInputs":
        """Return those at inputs ``u`` (n, 3) [g], [deg/s]; what is not known is nan."""
        signals, nothing = around.followed, np.full((n, 3), np.nan)
        known = {MEASURED[triad]: u.get(triad, nothing) for triad in MEASURED}
        known |= {name: signals[signal][:, None] for name, signal in SIGNALS.items()}
        known |= {AUXILIARY + name: value[:, None] for name, value in around.auxiliary.items()}
        followed = {signal: value[:, None] for signal, value in signals.items()}
        field = nothing if around.magnetic is None else around.magnetic
        out = {name: u[name] @ triads[name].E.T + triads[name].D for name in u}
        return cls({**known, "B": field}, out, followed)

    def added(self, effect: AppliedEffect) -> FloatArray:
        """Return what an effect adds (n, 3) to its triad's output [g], [deg/s]; nan where it is not known."""
        each = zip(effect.terms, effect.coefficients.T, strict=True)
        return np.asarray(sum(self._times(term, c, effect.triad) for term, c in each))

    def varied(self, effect: AppliedEffect) -> FloatArray:
        """Return the variance (n, 3) of what an effect adds, by its coefficients' [g^2], [deg^2/s^2]."""
        each = zip(effect.terms, effect.coefficients.T, effect.std.T, strict=True)
        return np.asarray(
            sum(
                (self._times(term, c + std, effect.triad) - self._times(term, c, effect.triad)) ** 2
                if is_inside(term)
                else self._times(term, std, effect.triad) ** 2
                for term, c, std in each
            )
        )

    def _times(self, term: Node, c: FloatArray, triad: str) -> FloatArray:
        def value(name: str) -> FloatArray:
            return c if name == COEFFICIENT else self._named(name, triad)

        def followed(call: Call) -> FloatArray | None:
            signal = _signal(call)
            return None if signal is None else self.followed[signal]

        found = evaluated(term, value, followed)
        return np.broadcast_to(found if is_inside(term) else found * c, (len(self.known["T"]), len(AXES)))

    def _named(self, name: str, triad: str) -> FloatArray:
        if name == "out":
            return self.out[triad]
        name = MEASURED[triad] if name == "u" else name
        vector, _, part = name.partition("_")
        if name in self.known or vector not in self.known:
            return self.known.get(name, np.full((1, 1), np.nan))
        value = self.known[vector]
        if part == "norm":
            return np.asarray(np.linalg.norm(value, axis=1, keepdims=True))
        if part in AXES:
            return value[:, AXES.index(part)][:, None]
        return value[:, [(i + int(part) - 1) % 3 for i in range(3)]]


def is_inside(term: Node) -> bool:
    """Say whether a term has its coefficient in it."""
    return any(each.name == COEFFICIENT for each in names(term))
