"""Weights fitted to paths: what they are judged by, what of an engine may be moved, and the search."""
