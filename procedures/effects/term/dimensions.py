"""Are the units of a term right? A sum is of one unit, what is in exp or log a number, in sin an angle.

A zero has any unit: ``max(0, u)``.
"""

from collections.abc import Mapping
from fractions import Fraction

from procedures.effects.term.functions import ALL_FUNCTIONS, FUNCTIONS, OPERATORS
from procedures.effects.term.grammar import Call, Name, Node, Number, Operation
from procedures.effects.term.inputs import AUXILIARY, input_of, inputs_of, known_input
from procedures.effects.term.units import NO_UNIT, Powers, parse_unit, power_of, unit_text
from procedures.errors import TermRefused

CONSTANTS = ("pi",)
COEFFICIENT = "c"  # the sensor's own, inside a term of the catalogue
ANGLE, SECOND = parse_unit("deg").powers, parse_unit("s").powers


class Dimensions:
    """Looks through a term of a triad; ``parameters`` are the powers of each parameter's unit, by name.

    A term of the catalogue has more inputs and functions than one of a user.
    """

    def __init__(
        self, text: str, triad: str, parameters: Mapping[str, Powers], *, is_of_catalogue: bool = False
    ) -> None:
        self.text, self.triad, self.parameters = text, triad, parameters
        self.input_of = known_input if is_of_catalogue else input_of
        self.functions = ALL_FUNCTIONS if is_of_catalogue else FUNCTIONS

    def of(self, node: Node) -> Powers | None:
        """Return the powers of a node's unit, None of a zero.

        Raises
        ------
        TermRefused
            With the place of a name that is not there, or of units that do not go together.
        """
        match node:
            case Number(value=0.0, unit=""):
                return None
            case Number():
                return self._unit_of(node)
            case Name():
                return self._name(node)
            case Operation():
                return self._operation(node)
            case Call():
                return self._operator(node) if node.name in OPERATORS else self._function(node)

    def refuse(self, node: Node, found: str, expected: str) -> TermRefused:
        """Return the refusal of a node."""
        return TermRefused(self.text, node.at, found, expected)

    def _unit_of(self, node: Number) -> Powers:
        if not node.unit:
            return NO_UNIT
        try:
            return parse_unit(node.unit).powers
        except TermRefused as error:  # its place is in the term
            at = self.text.index(node.unit, self.text.index("[", node.at)) + error.at
            raise TermRefused(self.text, at, error.found, error.expected) from None

    def _name(self, node: Name) -> Powers:
        if node.name in CONSTANTS:
            return NO_UNIT
        if node.name in self.parameters:
            return self.parameters[node.name]
        if (found := self.input_of(node.name, self.triad)) is None:
            there = [*self.parameters, *inputs_of(self.triad), f"{AUXILIARY}NAME", *CONSTANTS]
            raise self.refuse(node, node.name, f"one of {', '.join(there)}")
        return found.of_unit.powers

    def _operation(self, node: Operation) -> Powers | None:
        left = self.of(node.left)
        if node.sign == "**":
            power = power_of(node.right, self.text)
            return None if left is None else tuple(power * each for each in left)
        right = self.of(node.right)
        if node.sign in "+-":
            return self._same(node, (left, right))
        sense = 1 if node.sign == "*" else -1
        return tuple(a + sense * b for a, b in zip(left or NO_UNIT, right or NO_UNIT, strict=True))

    def _same(self, node: Node, each: tuple[Powers | None, ...]) -> Powers | None:
        known = [one for one in each if one is not None]
        for one in known:
            if one != known[0]:
                raise self.refuse(node, f"units {unit_text(known[0])} and {unit_text(one)}", "one unit")
        return known[0] if known else None

    def _function(self, node: Call) -> Powers | None:
        if (function := self.functions.get(node.name)) is None:
            there = f"one of {', '.join((*FUNCTIONS, *OPERATORS))}"
            raise self.refuse(node, f"{node.name}(", there)
        if len(node.arguments) != function.arity:
            raise self.refuse(node, f"{node.name} of {len(node.arguments)}", f"{node.name} of {function.arity}")
        of = tuple(self.of(argument) for argument in node.arguments)
        if function.of == "same":
            return self._same(node, of)
        if function.of == "root":
            return None if of[0] is None else tuple(Fraction(1, 2) * each for each in of[0])
        if function.of == "ratio":
            return self._same(node, of) and NO_UNIT
        allowed = {
            "number": (None, NO_UNIT), "angle": (None, NO_UNIT, ANGLE),
            "square": (None, NO_UNIT, tuple(2 * each for each in ANGLE)),
        }.get(function.of, of)  # fmt: skip
        if of[0] not in allowed:
            words = "a number" if function.of == "number" else "an angle, or a number in rad"
            raise self.refuse(node, f"{node.name} of a unit, {unit_text(of[0] or NO_UNIT)}", words)
        return NO_UNIT

    def _operator(self, node: Call) -> Powers | None:
        fits = len(node.arguments) == 2
        time = node.arguments[-1]
        if not fits or not isinstance(time, Name | Number) or self.of(time) != SECOND or not self._is_fixed(time):
            expected = f"{node.name}(x, tau), tau a parameter or a number in s, such as 60 [s]"
            raise self.refuse(node, f"{node.name} of something else", expected)
        if isinstance(time, Number) and not time.value > 0:
            raise self.refuse(time, f"{time.value:g} s", "a time above 0 s")
        return self.of(node.arguments[0])

    def _is_fixed(self, node: Name | Number) -> bool:
        return isinstance(node, Number) or node.name in self.parameters
