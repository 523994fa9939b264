"""The path follower: from one posture to the next along a path of poses, compiled."""
