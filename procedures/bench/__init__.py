"""The cube on its plate during and after a campaign: warm, on the right face, seated, headed.

`warm_up` and `dwell_length` before and during dwells, `seating_check` and `cube_attitude` live, `position_checks`
and `sign_errors` before the fit, `cube_measurement` and `cube_drift` for what the cube's faces are.
"""
