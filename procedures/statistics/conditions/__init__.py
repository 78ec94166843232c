"""What makes recorded samples something else than a sensor's noise: found in the samples, and named."""
