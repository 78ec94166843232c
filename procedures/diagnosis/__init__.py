"""Find what the residual says the model lacks, name it or say honestly that it cannot be named, and add it."""
