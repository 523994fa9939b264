"""The controls whose programs are read, one file each; `registry` lists them."""
