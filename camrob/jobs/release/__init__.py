"""The gate: what a program has to stand before it is released, and what is said of it."""
