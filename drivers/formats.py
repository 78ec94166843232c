"""The wire format that a device's address says."""

from drivers.device_url import CAN, DeviceUrl
from drivers.wire import FORMATS, WireFormat


def wire_of(address: DeviceUrl) -> WireFormat | None:
    """Return the format, None where the address does not say; raise `BadCanFile` for a wrong DBC or mapping."""
    if address.format == CAN:
        from drivers.can.format import can_format  # cantools takes 0.15 s to import

        return can_format(address.dbc, address.map, address.period)
    return FORMATS[address.format] if address.format is not None else None
