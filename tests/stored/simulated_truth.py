"""A simulated unit with much in it: noise that wanders, warming, effects, settling."""

from dataclasses import replace

from drivers.simulated.truth import Truth

TRUTH = replace(
    Truth.example(4), accel_instability_g=1e-6, gyro_instability_dph=0.1, temperature_rise_k=5.0,
    temperature_swing_k=2.0, temperature_swing_period_s=100.0, settle_rad=1e-4,
    effects={"accelerometer.relaxation": {"x": 1e-3}, "gyroscope.scale_temperature": {"x": 50.0}},
)  # fmt: skip
