"""What the simulator refuses.

SimulatorError
├── TruthRefused     a truth file or table breaks a rule
├── UnknownEffect    an effect or one of its coefficients has no such name
└── HandsRefused     the simulated hands did not do what they were told
    └── HandsUnreachable  they do not answer
"""

from collections.abc import Iterable


class SimulatorError(Exception):
    """The base of all that ``drivers.simulated`` raises on purpose."""


class TruthRefused(SimulatorError, ValueError):
    """A truth breaks a rule; says what was found and what is accepted."""

    def __init__(self, found: str, expected: str) -> None:
        self.found, self.expected = found, expected
        super().__init__(f"simulator truth: found {found}; expected {expected}")


class UnknownEffect(SimulatorError, ValueError):
    """An effect or coefficient has no such name; lists the names there are."""

    def __init__(self, name: str, accepted: Iterable[str]) -> None:
        self.name, self.accepted = name, tuple(accepted)
        super().__init__(f"no simulated effect {name!r}; expected one of {', '.join(self.accepted)}")


class HandsRefused(SimulatorError, OSError):
    """The simulated hands answered ``error`` or not at all."""

    def __init__(self, address: str, command: str, answer: str) -> None:
        self.address, self.command, self.answer = address, command, answer
        super().__init__(
            f"{address}: {command!r} found {answer!r}, expected an answer `ok ...`; check that `station simulate` "
            "runs and that --hands is the control address that it prints"
        )


class HandsUnreachable(HandsRefused):
    """The simulated hands do not answer; their device may have been started again and answer later."""
