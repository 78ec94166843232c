"""All fits together: a campaign becomes a solution, its residuals, and what is not observable.

`reduced_steps` (rates and totals), `joint_calibration` (the solve), `triad_calibration` (k, E, D with covariance),
`residuals`, `undetectable_tilt`, and the result in `solution_values`.
"""
