"""TOML files that people write: read with a line and a cure where they are wrong, and key by key."""
