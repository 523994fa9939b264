"""What the loop from program to measured part and back says."""
