"""From recorded counts to rates with standard uncertainty.

`sample_records` (what an IMU's output is), `sample_times`, `reference_time` and `time_decision` (when),
`count_rate` (rate of a dwell; by `count_propagation`, `count_kernels`, `count_noise`), `dwell_means` (vibration,
rate outputs), `encoder_angle` (of an encoder).
"""
