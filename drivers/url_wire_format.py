"""The wire format that a device's address says."""

from drivers.device_url import DeviceUrl
from drivers.device_url_parser import CAN
from drivers.wire import FORMATS, WireFormat


def frame_descriptions(address: DeviceUrl) -> dict[str, str]:
    """Return the texts of the files that the address needs to be read, by what they are.

    They belong beside recorded bytes: without them nobody can say what the frames meant.
    """
    if address.scheme == "wheel":
        from drivers.can.dbc_signals import text_of

        return {"dbc": text_of(address.dbc)}
    if address.format != CAN:
        return {}
    from drivers.can.can_format import OWN_DBC, OWN_MAP
    from drivers.can.dbc_signals import text_of

    return {"dbc": text_of(address.dbc or OWN_DBC), "map": text_of(address.map or OWN_MAP)}


def wire_of(address: DeviceUrl) -> WireFormat | None:
    """Return the format, None where the address does not say; raise `BadCanFile` for a wrong DBC or mapping."""
    if address.format == CAN:
        from drivers.can.can_format import can_format  # cantools takes 0.15 s to import

        return can_format(address.dbc, address.map, address.period)
    return FORMATS[address.format] if address.format is not None else None
