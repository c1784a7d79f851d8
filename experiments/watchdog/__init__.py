"""What the integrity monitor is made of: what others claim, how far a robot can get, what is behind an alarm, episodes."""
