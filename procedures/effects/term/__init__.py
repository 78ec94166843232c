"""An effect written as a term: grammar, units, inputs, values at the nodes, and the `Effect` made of them."""
