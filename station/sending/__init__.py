"""Calibrated samples streamed live: to a screen elsewhere, a program, a flight stack.

`sender` opens a feed and chooses the calibration; `live_samples` calibrates counts with times and flags; `sender`
gives them to all `outputs`: `to_stdout`, `to_udp`, `to_mavlink`, `to_foxglove`.
"""
