"""Simulated devices on a port of their own, on an IMU's time or the host's: a GNSS receiver, a camera, a wheel.

`truths` is what is true of them; `gnss_server`, `camera_server` (images by `camera_room`) and `wheel_on_can`
are each a `companion_device`, which serves what they send.
"""
