"""What a prediction says of the part."""
