"""Joints to poses and back: compiled kernels, the closed-form arm, batched evaluation."""
