"""A robot's program without a language: motions, what happens between them, and what a language has to be able to do."""
