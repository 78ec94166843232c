"""IMU samples between moments: increments, preintegration, gaps."""
