"""The loop from program to measured part and back."""
