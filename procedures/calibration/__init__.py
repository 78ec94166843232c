"""The calibration: all fits together, the solution, its residuals and what stayed open."""
