"""The rules that a program is held to, beside the file's story and by itself."""
