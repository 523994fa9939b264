"""What a log shows: scenes, signals, clocks, frames that nobody reported, and the program's path."""
