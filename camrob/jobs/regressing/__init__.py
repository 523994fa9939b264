"""Two outcomes of one post, held to each other."""
