"""What is made of the evidence."""
