"""The page of a program's run on the ideal controller."""
