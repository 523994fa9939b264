"""KRL, read as the controller would run it: text, values, statements, hooks, the run itself."""
