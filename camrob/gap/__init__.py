"""The sim-to-real gap: where it lies and which effect makes it."""
