"""What a procedure can refuse.

ProcedureError
├── NotObservable      the data do not determine what was asked for
├── WrongFace          a dwell's vertical axis is not the one its position names
├── FitsNoFace         a dwell's output is that of no face, as from a damaged sample
├── WrongMounting      the IMU does not sit in the cube as the campaign says
├── TurnsDisagree      two turns about one axis contradict each other's direction or revolutions
├── MoveContradicts    a move does not lead from the one of its placings to the other
├── TooShort           a dwell has too few samples to say anything
├── TermRefused        an effect's term or unit is outside the grammar
└── DoesNotFit         a model with an effect in it cannot be fitted: of the effect, never of the data
"""

from collections.abc import Sequence

from procedures.error_codes import ErrorCode


class ProcedureError(Exception):
    """The base of all that ``procedures`` raises on purpose."""

    code = ErrorCode.PROCEDURE


class NotObservable(ProcedureError):
    """The data do not determine what was asked for; ``missing`` says what would."""

    code = ErrorCode.NOT_OBSERVABLE

    def __init__(self, what: str, missing: Sequence[str]) -> None:
        self.what = what
        self.missing = tuple(missing)
        super().__init__(f"{what} cannot be determined: missing {', '.join(self.missing)}")


class WrongFace(ProcedureError, ValueError):
    """A dwell's vertical axis is not the one its position names."""

    def __init__(self, step: str, position: int, named: str, seen: str) -> None:
        self.step, self.position, self.named, self.seen = step, position, named, seen
        super().__init__(
            f"{step}: position {position} means {named}, but the counts show {seen}; "
            f"run `station diagnose` (it reports placement.label) or correct the position"
        )


class FitsNoFace(ProcedureError, ValueError):
    """One dwell's accelerometer output spoils the rest, and no other face would mend it."""

    def __init__(self, step: str, position: int) -> None:
        self.step, self.position = step, position
        super().__init__(
            f"{step}: found accelerometer outputs of no face, expected those of position {position}; "
            f"check it for damaged samples, or remove it"
        )


class WrongMounting(ProcedureError, ValueError):
    """The IMU does not sit in the cube as ``fixture.imu_axes`` says."""

    def __init__(self, named: str, seen: str) -> None:
        self.named, self.seen = named, seen
        super().__init__(f"imu_axes says {named}, but the counts show {seen}; correct fixture.imu_axes")


class TurnsDisagree(ProcedureError, ValueError):
    """Turns of one axis imply scale factors too far apart: a direction or a number of revolutions is wrong."""

    def __init__(self, first: str, per_turn: float, second: str, other_per_turn: float) -> None:
        self.first, self.per_turn, self.second, self.other_per_turn = first, per_turn, second, other_per_turn
        super().__init__(
            f"{first} shows {per_turn:.6g} and {second} {other_per_turn:.6g} per revolution, expected the same "
            f"within 10 %; correct the direction or the revolutions of one of them"
        )


class MoveContradicts(ProcedureError, ValueError):
    """A move does not lead from the one of its placings to the other: one of these has a wrong label."""

    def __init__(self, move: str, before: str, after: str, off_deg: float) -> None:
        self.move, self.before, self.after, self.off_deg = move, before, after, off_deg
        super().__init__(
            f"{move}: the gyroscopes show a rotation that differs by {off_deg:.0f} deg otherwise than from "
            f"{before} to {after}, expected less than 5; correct the position or axes of one of the two"
        )


class TooShort(ProcedureError, ValueError):
    """A dwell has too few samples to say anything."""

    code = ErrorCode.TOO_SHORT

    def __init__(self, step: str, samples: int, least: int) -> None:
        self.step, self.samples, self.least = step, samples, least
        super().__init__(f"{step} has {samples} samples, expected at least {least}; record it longer or remove it")


class DoesNotFit(ProcedureError, ValueError):
    """A model with effects added to it cannot be fitted: a word on the effects, never on the data."""


class TermRefused(ProcedureError, ValueError):
    """An effect's term or unit is outside the grammar; ``at`` counts characters of ``text`` from 0."""

    code = ErrorCode.TERM

    def __init__(self, text: str, at: int, found: str, expected: str) -> None:
        self.text, self.at, self.found, self.expected = text, at, found, expected
        super().__init__(f"column {at + 1} of {text!r}: found {found}, expected {expected}; correct the term")
