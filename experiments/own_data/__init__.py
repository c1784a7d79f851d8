"""Own data become a log: settings say which streams there are and what bounds their errors. See docs/own-data.md.

Read `settings` and what it is made of (`table`, `kinds`, `stream`, `facts`), then `units`, the door; then `channels`, which
topic is which stream; `reading`, `readings`, `driven`: from messages to records; and `conversion`, the whole.
"""

from experiments.own_data.conversion import Converted, convert
from experiments.own_data.settings import Settings, read_settings

__all__ = ["Converted", "Settings", "convert", "read_settings"]
