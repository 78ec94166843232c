"""CAN: received frames as a stream of checked records, and counts described by a DBC and a mapping file.

`can_port` (a bus, by python-can) or `can_log` (a log) gives bytes of `frame_record`s. `mapping_file` says which
signals (`dbc_signals`) are the IMU's, `frame_joiner` makes samples of frames, and
`can_format` is all of this as a `drivers.wire` format. `wheel_signal` reads a speed of a vehicle.
"""
