"""Statistics and least squares that know nothing of inertial sensors.

Fits: `least_squares`, `line_fits`. Tests: `significance`. Calibrations: `calibration_drift`, `population`. Noise:
`allan_deviation`, `spectrum`, `spectral_shape`. Recordings at rest: `recording_conditions`,
`row_patterns`, `noise_conditions`.
"""
