"""What sensors say, how robots moved, and what one instant gives. What is public is at `filter`.

Read the modules in this order: names, record, sensors, radians, relative, measurements, differences, odometry, presence, frame,
seen.
"""
