"""Statistics and least squares that know nothing of inertial sensors."""
