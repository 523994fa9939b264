"""Faults in program text, drawn by rule over the program's own syntax tree; see ../text_faults.py."""
