"""The page of `camrob verify`."""
