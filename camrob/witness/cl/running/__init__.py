"""In which order a program's blocks are run, and what they compute: jumps, loops, calls, variables."""
