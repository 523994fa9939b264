"""The second opinion: judges a robot program without any of the code that made it.

Nothing here imports anything of camrob but `camrob.errors` and `camrob.text` (tests/structure). From the CL file's
text it works out what was asked for, from cell.toml and setup.toml what the machine is, from the program's text what the
controller would do; `rules` compares the two stories, and says what was judged and what could not be.
"""
