"""All kernels compiled ahead of time: `python -m camrob.warm`."""
