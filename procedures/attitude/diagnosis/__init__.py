"""The closed loop for attitude: what the residual says the mixer's model lacks, traced, added, and judged."""
