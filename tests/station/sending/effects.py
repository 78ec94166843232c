"""Effects of a calibration: of the input, of the other triad, and of a temperature that lags."""

EFFECTS = [
    {"name": "accelerometer.quadratic", "unit": "g/g^2",
     "coefficients": {axis: {"value": 3e-4, "std": 1e-5} for axis in "xyz"}},
    {"name": "gyroscope.g_sensitivity", "unit": "deg/h/g",
     "coefficients": {f"{a}{b}": {"value": 0.7, "std": 0.01} for a in "xyz" for b in "xyz"}},
    {"name": "gyroscope.temperature_lag", "unit": "deg/h/K",
     "coefficients": {"x.1": {"value": 2.0, "std": 0.01}, "tau_s": {"value": 40.0, "std": 1.0}}},
]  # fmt: skip
