"""How a camera, an IMU and GNSS start together: structure up to scale, scale, axes, the clock of the camera."""
