"""MuJoCo simulates the team: world, drive, sensors, episode."""
