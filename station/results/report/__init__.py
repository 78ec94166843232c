"""The calibration report: one HTML file that needs nothing else, on screen or on A4 paper."""
