"""The inner layer: a window of keyframes by IMU, GNSS velocity and camera."""
