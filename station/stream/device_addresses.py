"""What may stand where the address of an IMU or of a receiver is asked for; nothing is opened."""

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress, MavlinkAddress
from drivers.errors import BadDeviceUrl

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
