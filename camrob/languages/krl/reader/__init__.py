"""The reader of KRL, by any post. It shares nothing with the writer."""
