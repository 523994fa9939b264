"""What instruments said: measurement logs and their readers."""
