"""Roll and pitch online: the complementary filter of You and Lee and the Kalman filter, which is the default.

`attitude_estimate` runs either on an `attitude_log`, also in both directions; `filter_choice` holds the filters'
names and the gains of the paper, `kalman.kalman_settings` those of the other; `gain_tuning` finds gains,
`attitude_diagnosis` finds what a filter's model lacks, `axes_check` finds swapped axes. Attitude is the *down
vector*, gravity's unit vector in body axes, which has no singularity. Source: You, Lee, *An accelerometer-aided
mixing algorithm for strapdown attitude (roll, pitch)*; physics and figures: ``docs/explanation/attitude.md``.
"""
