"""The writer of RAPID."""
