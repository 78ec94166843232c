"""Statistics and least squares that know nothing of inertial sensors.

Fits: `least_squares` (iterations and convergence of every fit), `line_fits`. Tests: `significance`. Calibrations:
`calibration_drift` (control chart with its limit, forecast), `population`. Noise: `allan_deviation`, `spectrum`,
`spectral_shape`. Recordings at rest: `recording_conditions`, `row_patterns`, `noise_conditions`.
"""
