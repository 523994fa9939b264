"""Paths on which the tool may not even roll, for arms with axes to spare: the shortest motion of the joints that keeps clear."""
