"""Where the gap lies: by stage, along the path, at corners, in time, and in the standards' figures."""
