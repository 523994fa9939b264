"""Torques and gravity loads."""
