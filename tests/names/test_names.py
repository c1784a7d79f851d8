"""What can be a name, what stands for one, and words with names in them."""

import pytest

from filter import InvalidInput, Team
from filter.records.names import InWords, names_in, numbered, place_of


def test_what_has_no_name_is_numbered():
    assert numbered("r", 3) == ("r0", "r1", "r2")
    assert numbered("l", 0) == ()


@pytest.mark.parametrize("names", [["alice"], ["a.b-c_1", "Übung", "9"], ["x" * 64], []])
def test_names_are_words_that_can_be_parts_of_files_names(names):
    assert names_in("robots", names) == tuple(names)


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["a b"], "letters, digits"), (["a/b"], "letters, digits"), ([".a"], "letters, digits"), ([""], "letters, digits"),
        (["x" * 65], "64 at most"), (["a\n"], "letters, digits"), (["a", "b", "a"], "'a' twice"), ([1], "names"),
        (None, "names"),
    ],
)  # fmt: skip
def test_others_are_refused(names, said):
    with pytest.raises(InvalidInput, match=said):
        names_in("robots", names)


def test_there_are_as_many_as_there_have_to_be():
    assert names_in("two", ["a", "b"], 2) == ("a", "b")
    with pytest.raises(InvalidInput, match="1 names"):
        names_in("two", ["a"], 2)


def test_a_name_has_its_place_or_is_refused_with_the_nearest():
    assert place_of("a robot", "bob", ["alice", "bob"]) == 1
    with pytest.raises(InvalidInput, match="a name of a robot, as alice; came 'alcie'"):
        place_of("a robot", "alcie", ["alice", "bob"])
    with pytest.raises(InvalidInput, match="a name of a robot; came 7"):
        place_of("a robot", 7, ["alice", "bob"])


class Met(InWords):
    """One robot met another, as something tells."""

    def __init__(self, one, other, source):
        self.one, self.other, self.source = one, other, source

    def _in_words(self, words):
        return f"{words(self.one)} met {words(self.other)}: {words(self.source)}"


def test_words_have_numbers_as_text_and_names_in_a_team():
    met = Met(0, 2, Met(2, 1, "nobody knows"))
    assert str(met) == "robot 0 met robot 2: robot 2 met robot 1: nobody knows"
    assert met.named(Team(["alice", "bob", "carol"])) == "alice met carol: carol met bob: nobody knows"
    assert Team(3).words(met) == "r0 met r2: r2 met r1: nobody knows"
