"""Joint fits of a campaign: accelerometers from dwells in known positions, gyroscopes from manual rotations.

`bench_parameters` (plate, faces, headings, gravity), `accelerometer_fit`, then for the gyroscopes
`manual_rotations`, `rotation_tilt`, `transfer_rotation` and `placement_transfers` as rows, `gyroscope_model` (the
residual) and `gyroscope_fit`.
"""
