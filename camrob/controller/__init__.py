"""What a controller does with a program's text: replay and simulation."""
