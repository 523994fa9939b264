"""The next experiment: which motion would separate the closest rivals."""
