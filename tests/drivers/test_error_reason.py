"""The system's words are said once, whatever a library wraps around them."""

import errno

import pytest
import serial

from drivers.error_reason import reason_of


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (
            serial.SerialException(2, "could not open port X: [Errno 2] No such file or directory: 'X'"),
            "No such file or directory",
        ),
        (serial.SerialException("Could not configure port: (5, 'Input/output error')"), "Input/output error"),
        (
            serial.SerialException("device reports readiness to read but returned no data (device disconnected?)"),
            "it sends nothing any more: unplugged, or another program reads it too",
        ),
        (OSError(errno.ENODEV, "No such device"), "No such device"),
        (ConnectionRefusedError(errno.ECONNREFUSED, "Connection refused"), "Connection refused"),
        (RuntimeError("the adapter says no"), "the adapter says no"),
        (ValueError(), "ValueError"),
    ],
)
def test_a_reason_is_one_clause(error: Exception, said: str) -> None:
    assert reason_of(error) == said
