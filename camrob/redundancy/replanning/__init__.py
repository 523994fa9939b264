"""Plans made anew where they touch something or can't be followed, and only there; and until when plans are bettered."""
