"""What others have recorded, as topics and messages: CSV files, and bags of ROS 1 and ROS 2. No ROS is needed."""

from experiments.recorded.inputs import Input, LeftOut, Message, Taker, Topic
from experiments.recorded.opened import opened
from experiments.recorded.words import nearest

__all__ = ["Input", "LeftOut", "Message", "Taker", "Topic", "nearest", "opened"]
