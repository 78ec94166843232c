"""The joint fits: accelerometers from dwells in known positions, gyroscopes from hand turns."""
