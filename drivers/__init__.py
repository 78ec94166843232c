"""Bytes to records: wire formats, framing, ports and the simulated devices."""
