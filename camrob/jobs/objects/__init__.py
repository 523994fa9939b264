"""The verbs on objects: what was read goes in, what was found comes out, and no file is touched."""
