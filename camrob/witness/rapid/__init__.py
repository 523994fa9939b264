"""RAPID, read as the controller would run it: text, data, statements, the run itself."""
