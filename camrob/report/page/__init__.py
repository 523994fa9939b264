"""What reports are made of: the page and its viewer, charts, pictures, tables."""
