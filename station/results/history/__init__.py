"""What the stored calibrations say together: of a unit over time, and of all units of a model."""
