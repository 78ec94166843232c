"""Simulated devices on a port of their own, on an IMU's time or the host's: a GNSS receiver, a camera, a wheel.

`truths` says what is true of them; `autopilot` and `camera_room` make what they send; `gnss_server`,
`camera_server` and `wheel_on_can` are each a `companion_device`, which serves it.
"""
