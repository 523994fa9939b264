"""The reader of RAPID, by any post. It shares nothing with the writer."""
