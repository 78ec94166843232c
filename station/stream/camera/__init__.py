"""A camera beside the IMU: what it is, what it sends, and the features that are followed through its images."""
