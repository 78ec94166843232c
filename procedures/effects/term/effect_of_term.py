"""An `Effect` made of terms that a user wrote: a law whose names and units are checked.

Parameters of a term are fitted with the coefficients, by their logarithm, from a search over their ranges.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from procedures.effects.effect import Effect
from procedures.effects.excitation import Columns, Excitation
from procedures.effects.term.dimensions import CONSTANTS, Dimensions
from procedures.effects.term.functions import FUNCTIONS, OPERATORS
from procedures.effects.term.grammar import names, parse
from procedures.effects.term.inputs import input_of
from procedures.effects.term.law import OUTPUT_UNITS, Law
from procedures.effects.term.units import Unit, parse_unit, unit_text
from procedures.errors import TermRefused
from procedures.frames import AXES

MAX_TERMS, MAX_PARAMETERS = 8, 2
AT_END = 1e-9  # of an end of a parameter's range, within which a value stands there
SEPARATE_BY = "the campaign again in another order, with other temperatures and rates"
NOT_CORRECTED = "specific to the campaign or to earlier steps; one sample does not determine it"


@dataclass(frozen=True, slots=True)
class TermEffect(Law):
    """A law of a user's own; raises `TermRefused` for a name or a unit that does not fit."""

    def __post_init__(self) -> None:
        for name in self.parameters:
            there = (*CONSTANTS, *FUNCTIONS, *OPERATORS, *AXES)
            if name in there or input_of(name, self.triad) is not None:
                raise TermRefused(name, 0, f"a parameter {name}", "a name that no input or function has")
        powers = {name: parse_unit(one.unit).powers for name, one in self.parameters.items()}
        used = set[str]()
        for text in self.terms:
            node = parse(text)
            used |= {each.name for each in names(node)}
            adds = Unit(1.0, Dimensions(text, self.triad, powers).of(node) or parse_unit("1").powers)
            whole, wanted = (adds * parse_unit(self.unit)).powers, parse_unit(OUTPUT_UNITS[self.triad]).powers
            if whole != wanted:
                found = f"{unit_text(whole)} of a coefficient in {self.unit} times the term"
                raise TermRefused(text, 0, found, f"{unit_text(wanted)}, what {self.triad}s put out")
        if unused := sorted(set(self.parameters) - used):
            raise TermRefused(self.terms[0], 0, f"no {unused[0]} in it", "every parameter of [shape]")

    def columns(self, seen: Excitation) -> list[Columns]:
        """Return its columns at every place where a search of its parameters begins; none where not known."""
        if self.missing(seen):
            return []
        found = [self.at(seen, start) for start in self.starts(seen)]
        parts = ((way, way.gyro if way.accel is None else way.accel) for way in found)
        return [way for way, part in parts if part is not None and np.isfinite(part).all()]

    def at_ends(self, values: Mapping[str, float]) -> tuple[str, ...]:
        """Say which parameters stand at an end of their range; ``values`` are in their units."""
        return tuple(
            f"{name} is at the end of its range ({one.low:g} to {one.high:g} {one.unit}): widen it"
            for name, one in self.parameters.items()
            if one.low < one.high and not one.low * (1 + AT_END) < values[name] < one.high * (1 - AT_END)
        )

    def effect(self) -> Effect:
        """Return it as a diagnosis takes it."""
        return Effect(
            name=f"{self.triad}.{self.name}", unit=self.unit, physics=self.equation, source=self.source,
            plausible=self.plausible, columns=self.columns, separate_by=SEPARATE_BY, at=self.at, laws=(self,),
            ranges=self.ranges, not_corrected=NOT_CORRECTED if self.looks_back else "",
        )  # fmt: skip
