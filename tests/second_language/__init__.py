"""A robot language of our own, line by line, that proves the seam: this folder, a line of a registry, a file for the witness.

program NAME            begins a file; `end` ends it
set NAME VALUE          a setting
base follows X Y Z A B C    (or `base stands ...`)
tool X Y Z A B C
load M X Y Z                kg, and its centre in mm
speed V                 m/s of what follows
axes A1 .. A6 | E1 ..   all axes together
pose X Y Z A B C | S T | E1 ..
line X Y Z A B C | E1 .. [~]    ~: rounded off
arc X Y Z A B C | E1 .. | X Y Z A B C | E1 .. [~]    by way of the first
do ...                  a line of one of the cell's hooks
wait T                  seconds
part NAME               runs another file
# ...                   a remark
"""

from second_language.lines_language import LANGUAGE

__all__ = ["LANGUAGE"]
