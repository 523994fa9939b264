"""A ninth author's sealed cases: see README.md."""
