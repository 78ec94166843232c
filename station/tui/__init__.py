"""The screens of a guided calibration: they draw a `CalibrationView` and send `OperatorCommand`s, nothing else."""
