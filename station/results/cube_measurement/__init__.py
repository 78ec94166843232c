"""``station fixtures measure``: a cube by the IMUs that were calibrated in it, against all that is known of it."""
