"""What a cube's machining tolerances do to an accelerometer calibration, and what tolerances an accuracy needs.

After Yao, Hu and He 2018, tables 2 and 3, equations (13)-(20), and beyond it: any tilt of any face, quadratic
coefficients, the joint solve. `drawing_items` (how they add up), `estimator_errors` (exact, and by Monte Carlo),
`tolerances_for_accuracy` (worst case, and the way back), `improvements` and `neglected_effects`.
"""
