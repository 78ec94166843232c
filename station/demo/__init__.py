"""The demo: a campaign on a simulated unit, from the set-up to a calibration that is compared with the truth.

`run` starts the simulated `device`, puts the bench of its truth into a database (`example_bench`), lets the guided
calibration run without an operator and prints how the result differs from the truth (`comparison`).
"""
