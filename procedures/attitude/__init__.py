"""Roll and pitch online: the complementary filter of You and Lee and the Kalman filter, which is the default.

`attitude_estimate` runs either on an `attitude_log`; `complementary_gains` and `kalman.kalman_settings` are their
settings, `filter_choice` is for live units; `gain_tuning`, `attitude_diagnosis` and `axes_check` look at a log.
Attitude is the *down vector*, gravity's unit vector in body axes, which has no singularity. Source: You, Lee, *An
accelerometer-aided mixing algorithm for strapdown attitude (roll, pitch)*; ``docs/explanation/attitude.md``.
"""
