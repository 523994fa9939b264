"""Programs: the writer of KRL and an independent reader of it."""
