"""Where real bags of other people are, and what makes a log of those of robots that stand."""

import os

import pytest

BAGS = os.environ.get("TIERS_BAGS")
needs_bags = pytest.mark.skipif(BAGS is None, reason="TIERS_BAGS names no folder of the real bags")
STANDING = """
[team]
arena = [[-2.0, -3.0], [9.0, 9.0]]
speed_limit = 0.0  # they stand
turn_rate_limit = 0.0
[input]
stamp = "header"
types = "humble"
[robots]
1 = {}
2 = {}
3 = {}
4 = {}
5 = {}
6 = {}
7 = {}
[every_robot]
range = { topic = "/uwb/tof/n_{robot}/n_{target}/distance", bound = [0.0, 1.0] }
truth = { topic = "/vrpn_client_node/turtlebot{robot}/pose" }
"""
