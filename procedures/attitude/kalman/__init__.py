"""The Kalman filter of attitude, velocity and biases.

`kalman_filter` runs it over a log or a sample at a time: `strapdown_integration` between updates, the aids of
`kalman_measurements`, state and covariance in `kalman_state`. `kalman_settings` has the noise, and from how many
sigmas a measurement counts less. `unaided_motion` sets it up where there is no aid.
"""
