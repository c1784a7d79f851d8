"""Settings of conversions: little ones that work, to be spoilt."""

TEAM = """
[team]
arena = [[-10, -10], [10, 10]]
landmarks = { gate = [1.0, 2.0] }
speed_limit = 1.0
turn_rate_limit = 2.0
"""
OF_BAGS = TEAM + '\n[input]\nstamp = "header"\n'
OF_TABLES = TEAM + '\n[input]\nstamp = "t"\nstamp_unit = "s"\n'


def of_robots(head, **streams):
    """Return settings of the robots a and b, in which a has streams."""
    lines = "".join(f"{kind} = {{ {table} }}\n" for kind, table in streams.items())
    return f"{head}\n[robots.a]\n{lines}\n[robots.b]\n"
