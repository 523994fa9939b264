"""Summaries in the terminal: of a post, and of verbs that have no page of their own."""
