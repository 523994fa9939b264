"""The published method: the virtual joint over a whole program, and posture revision."""
