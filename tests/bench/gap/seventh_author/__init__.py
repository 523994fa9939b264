"""A seventh author's cases: one small sealed family."""
