"""What of a summary is reckoned with elsewhere."""
