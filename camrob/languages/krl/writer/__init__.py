"""The writer of KRL."""
