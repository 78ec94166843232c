"""Simulated devices: the physics of a unit and its bench, down to bytes on a port.

Listed in `docs/reference/simulated-devices.md`.
"""
