"""The page of placements."""
