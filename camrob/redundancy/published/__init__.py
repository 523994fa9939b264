"""The published method: the virtual joint over a whole program, posture revision, and the loop to the letter."""
