"""Many jobs at once: what a batch shall do, and who does it."""
