"""A calibration applied to what was recorded: sources of samples, the way through, and what is said of it."""
