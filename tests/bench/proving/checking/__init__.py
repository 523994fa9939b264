"""A checker of bounds that are proved: it shares no code with their prover."""
