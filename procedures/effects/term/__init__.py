"""The equation of an effect as terms: grammar, units, inputs, values, and the `Law` that all users are made from."""
