"""Guided calibration: the engine that watches the counts, and what it shows and takes."""
