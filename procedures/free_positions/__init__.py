"""Recordings without declared positions: rests found, moves between them, calibration from both.

`rest_detection` finds rests, `norm_fit` fits accelerometers to them (`pose_means` to a table of means),
`free_attitudes` and `free_attitude_fit` combine them with the twelve positions, `gyroscopes_from_moves` follows.
"""
