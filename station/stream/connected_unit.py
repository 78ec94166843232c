"""Which unit is connected, and which addresses a user may give for an IMU or a receiver.

The identity frame says the unit, or the operator where the device has none.
"""

from dataclasses import dataclass

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress, MavlinkAddress
from drivers.errors import BadDeviceUrl, DriverError
from drivers.wire import Identity
from procedures.errors import ErrorCode


@dataclass(frozen=True, slots=True)
class Unit:
    """An IMU's model and serial number, and its nominal sample period [s]."""

    model: str
    serial: str
    period: float


class UnitUnknown(DriverError):
    """The wire says no model or serial number and nobody else did; ``missing`` names which."""

    def __init__(self, port: str, missing: str) -> None:
        self.port, self.missing = port, missing
        super().__init__(f"{port}: the device does not say its {missing}, expected one; give it with --{missing}")


class UnitChanged(DriverError):
    """Another unit answers than the one the campaign began with, or, ``is_entered``, than the one named."""

    code = ErrorCode.WRONG_UNIT

    def __init__(self, port: str, found: str, expected: str, *, is_entered: bool = False) -> None:
        self.port, self.found, self.expected = port, found, expected
        then = "as at the start; connect that unit again, or begin a new campaign"
        if is_entered:
            then = "as was entered; connect that unit, or correct the serial number"
        super().__init__(f"{port}: serial number {found} is connected, expected {expected} {then}")


def unit_of(
    port: str, identity: Identity | None, period: float, model: str | None, serial: str | None,
    *, has_begun: bool = False,
) -> Unit:  # fmt: skip
    """Return the unit; what the wire says stands before what the operator says.

    ``has_begun``: model and serial number are those of a resumed campaign.

    Raises
    ------
    UnitUnknown
        If neither says model or serial number.
    UnitChanged
        If the operator, or the campaign, named another serial number than the wire does.
    """
    text = identity or Identity()
    if text.serial and serial and text.serial != serial:
        raise UnitChanged(port, text.serial, serial, is_entered=not has_begun)
    found = {"serial": text.serial or serial, "model": text.model or model}
    for name, value in found.items():
        if not value:
            raise UnitUnknown(port, name)
    return Unit(str(found["model"]), str(found["serial"]), period)


def refuse_other(port: str, identity: Identity | None, unit: Unit) -> None:
    """Raise `UnitChanged` where the wire now says another serial number or model."""
    if identity is not None and identity.serial and identity.serial != unit.serial:
        raise UnitChanged(port, identity.serial, unit.serial)


RECEIVER = "a GNSS source: mavlink:LINK:WHERE"
OTHER_SCHEMES = {  # what is no IMU, by scheme, and where it belongs
    "mavlink": ("a MAVLink link", "--gnss takes a receiver's"),
    "camera": ("a camera", "--camera takes a camera's file"),
    "wheel": ("a wheel", "--wheel takes a wheel's file"),
}


def imu_address(typed: str) -> DeviceAddress:
    """Return the address of an IMU; raise `BadDeviceUrl` if it is none, or that of something else."""
    return not_another(parse_device_url(typed))


def not_another(address: DeviceAddress) -> DeviceAddress:
    """Return an address that may be an IMU's; raise `BadDeviceUrl` for that of something else."""
    if address.scheme in OTHER_SCHEMES:
        what, option = OTHER_SCHEMES[address.scheme]
        expected = f"an IMU's, such as /dev/ttyUSB0; {option}"
        raise BadDeviceUrl(address.public_text, f"the address of {what}", expected)
    return address


def receiver_address(typed: str) -> MavlinkAddress:
    """Return the address of a GNSS receiver; raise `BadDeviceUrl` if it is none."""
    address = parse_device_url(typed, "receiver")
    if not isinstance(address, MavlinkAddress):
        raise BadDeviceUrl(typed, f"scheme {address.scheme!r}", RECEIVER)
    return address
