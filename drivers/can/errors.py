"""What a DBC or a mapping file can be refused for."""

from drivers.errors import DriverError


class BadCanFile(DriverError, ValueError):
    """A DBC or a mapping file breaks a rule; ``line`` is None where no line can be named."""

    def __init__(self, path: str, line: int | None, found: str, expected: str) -> None:
        self.path, self.line, self.found, self.expected = path, line, found, expected
        where = path if line is None else f"{path}, line {line}"
        super().__init__(f"{where}: found {found}; expected {expected}")
