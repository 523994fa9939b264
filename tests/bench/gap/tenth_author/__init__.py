"""A tenth author's cases: used robots, laboratories' benches and odd machines, in their own tables. Nothing of camrob."""
