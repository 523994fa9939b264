"""The page of many jobs."""
