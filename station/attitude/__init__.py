"""Roll and pitch, from logs and live.

A log is read by `attitude_log` or `general_log` and its results are written by `attitude_json`. A live unit's
ticks go through `live_filters`, which runs `live_kalman_filter` and complementary filters; each gives a
`live_readings.FilterReading`. `error_at_rest` compares calibrated with nominal readings.
"""
