"""The team is simulated: world (in MuJoCo, or kinematic), drive, sensors, episode."""
