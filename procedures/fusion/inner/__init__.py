"""The inner layer: a window of keyframes by IMU, GNSS velocity, wheel and camera.

`window_state` is estimated; `window_terms`, `wheel_aid` and `landmarks` give the residuals that `window_problem`
sums. `inner_window` fits them for `inertial_window` (no camera) and `visual_inertial_window`; what leaves the
window is in `marginalised_keyframes`.
"""
