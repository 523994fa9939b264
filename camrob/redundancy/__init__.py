"""Choosing the redundancy: which posture of many makes the path."""
