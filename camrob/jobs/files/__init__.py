"""Files that jobs read, write and compare."""
