"""The report of a post."""
