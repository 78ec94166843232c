"""Bytes to records: addresses, ports, wire formats, framing, and the simulated devices.

`address_parsing` makes `addresses` of what is typed, with the defaults of a line (baud, parity); `ports` opens
one as a port of bytes (`serial_port`, `network_ports`, `triad_port`, `can`, `mavlink`, `camera`); `framing` finds
the frames of a `wire` format in them and counts what is missing (`counter_and_time_wrap`); `host_times` stamps
what has no time.
"""
