"""Lists the questions: what there is to run, and what it is about, by the first sentence that each program says of itself."""

import ast
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
# In the order in which they are best read.
TOUR = ("one_robot", "team", "own_log", "rejected_lie", "tolerated_lie", "no_compass", "watching", "large_team", "late_records")
QUESTIONS = {
    "Before all others": ("warm_up",),
    "Your own log": ("follow", "live"),
    "A moving team": ("moving_team", "prove", "watch"),
    "When a bound breaks": ("faults",),
    "Your own data": ("sample", "convert"),
    "Against a Kalman filter": ("ekf_comparison",),
    "Real robots": ("mrclam", "mrclam_sweep", "mrclam_margins", "calibrate", "standing_team"),
    "The paper": ("static_localization", "search_strategy"),
    "How tight, how fast": ("tightness", "range_only", "scaling", "benchmark", "certified_bounds"),
}


def first_sentence(path: Path) -> str:
    """Return the first sentence of a module's docstring, without running the module."""
    said = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return re.split(r"(?<=[.?!])\s", said, maxsplit=1)[0].replace("\n", " ")


def main() -> int:
    """Print the list; return the exit code."""
    print("A tour, in this order; each by python -m experiments.tour.NAME\n")
    for name in TOUR:
        print(f"  {name:20} {first_sentence(HERE / 'tour' / f'{name}.py')}")
    print("\nQuestions; each by python -m experiments.NAME, with --help for its options")
    for title, names in QUESTIONS.items():
        print(f"\n{title}")
        for name in names:
            print(f"  {name:20} {first_sentence(HERE / f'{name}.py')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
