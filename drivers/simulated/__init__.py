"""Simulated devices: the physics of a unit and its bench, down to bytes on a port.

`truth` (a unit and its bench) and `effects` (error terms) drive `sensor_model`, which counts, and `sensor_noise`;
`bench_in_memory` and `imu` move it (`cube_motion`, `vehicle_track`); `device` makes bytes, `faults` damages them,
`server` sends them over one of the `lines`, moved through `bench_control`. `companions` are receivers, cameras and
wheels. docs/reference/simulated-devices.md lists them.
"""
