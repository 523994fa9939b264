"""A third author's cases of a robot's gap: sealed, opened once. Written from physics, without sight of what is judged."""
