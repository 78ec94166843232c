"""The equation of an effect as terms: grammar, units, inputs, values, and the `Law` that all is made from."""
