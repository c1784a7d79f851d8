"""Who is right again, by evidence: what was known stays, what they say is heard at once, and all who are over are one."""

import shutil
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from helpers.proved.doubts import followed, proved, refusal
from helpers.proved.runs import forge, lines_of, moved

from experiments.proof.alternatives.doubts import AGAIN, Doubts
from experiments.proof.edges import add
from experiments.proof.given.frame import Start
from experiments.proof.given.log import Log
from experiments.prove import ALTERNATIVES, HEADINGS, LINES
from filter.diagnosis import evidence, judging


@pytest.fixture(scope="module")
def acquitted(tmp_path_factory):
    """Return the folder of a run in which two suspects are acquitted by little evidence, and a sighting alone is left."""
    path = tmp_path_factory.mktemp("acquitted")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evidence, "INSTANTS", 9)
        patch.setattr(evidence, "OFTEN", 5)
        patch.setattr(judging, "FITS", 1)
        followed(path, "misread", 2, 25, 0)
    return path


def test_who_is_right_again_is_heard_at_once_and_that_is_proved(acquitted):
    first, second, union, end = [record for record in lines_of(acquitted, ALTERNATIVES) if not {*record} & {"instants"}]
    assert first["lines"]
    assert second["lines"]
    assert union["unites"][1:] == [first["name"], second["name"]]
    assert union["name"] == union["unites"][0] + "-"
    assert [kind for kind, *_ in end["aside"]] == ["sighting"]
    assert proved(acquitted)[0][AGAIN] == 2


def test_who_cannot_be_right_again_is_gone_and_that_is_proved(tmp_path):
    _, beliefs = followed(tmp_path, "swap", 4, 25, 0)
    (record,) = [record for record in lines_of(tmp_path, ALTERNATIVES) if "again" in record]
    assert [suspect.who for suspect in beliefs[-1].aside] == [("exchange", 1, 2)]
    assumed, _ = proved(tmp_path)
    assert assumed[AGAIN] == 1
    forge(tmp_path, ALTERNATIVES, lambda records: records[records.index(record)].update(headings=[], lines=[]))
    assert "is narrower than that of an alternative" in refusal(tmp_path)


def right_again(records):
    return next(record for record in records if "again" in record)


def nothing_is_heard(records):
    right_again(records).update(headings=[], lines=[])


def another_case_is_meant(records):
    one, other = [record for record in records if "again" in record]
    one |= {name: other[name] for name in ("again", "wrong")}


def another_is_meant(records):
    right_again(records)["wrong"] = [["past", 0, -1]]


def one_is_right_again_twice(records):
    records.insert(records.index(right_again(records)), right_again(records) | {"name": "twice"})


def the_last_suspect_is_listened_to(records):
    records.pop()


def somebody_else_is_put_aside(records):
    records[-1]["aside"] = [["compass", 0, -1]]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (nothing_is_heard, "edges"),
        (the_last_suspect_is_listened_to, "ends without a proof"),
        (somebody_else_is_put_aside, "somebody is put aside who was not found to be wrong"),
        (another_case_is_meant, "too far inside"),
        (another_is_meant, "something else is right again"),
        (one_is_right_again_twice, "KeyError"),
    ],
)
def test_a_forged_acquittal_is_refused(acquitted, change, why, tmp_path):
    copy = Path(shutil.copytree(acquitted, tmp_path / "copy"))
    forge(copy, ALTERNATIVES, change)
    assert why in refusal(copy)


def again(folder, *names):
    """Return records by which cases that are left, of such suspects, are right again at the end; nothing more is heard."""
    (heading,) = lines_of(folder, HEADINGS)[-1:]
    stamp = {key: heading[key] for key in ("t", "version")} | {"headings": [], "lines": []}
    some = [one for one in lines_of(folder, ALTERNATIVES) if one["t"] == heading["t"] and one["wrong"][0][0] in names]
    return [{**stamp, "name": one["name"] + "+1", "again": one["name"], "wrong": one["wrong"]} for one in some]


def united(folder):
    """Have two of the cases that are left right again, and united within what is said at the end; return the records."""
    (heading,), some = lines_of(folder, HEADINGS)[-1:], again(folder, "sensor", "body")
    lines = [line for line in lines_of(folder, LINES) if line["t"] == heading["t"]]
    union = {"name": "both", "unites": [one["name"] for one in some], "headings": [heading], "lines": lines}
    return [*some, {key: heading[key] for key in ("t", "version")} | union]


def test_cases_that_are_over_are_united_in_what_holds_in_each(doubtful, tmp_path):
    copy, more = Path(shutil.copytree(doubtful, tmp_path / "copy")), united(doubtful)
    forge(copy, ALTERNATIVES, lambda records: records.extend(more))
    assumed, _ = proved(copy)
    assert assumed[AGAIN] == 2


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda *_, one: one["lines"][0].update(offset=moved(one["lines"][0]["offset"], -0.1)), "edges 0.1 m farther out"),
        (lambda *_, one: one["unites"].append("nobody"), "KeyError"),
        (lambda *_, one: one.update(unites=[]), "united that are not over"),
        (lambda first, *_, one: one["unites"].append(first["again"]), "KeyError"),
        (lambda first, *_, one: one.update(name="13"), "a second alternative 13"),
        (lambda first, *_, one: first["wrong"].append(["past", 0, -1]), "something else is right again"),
        (lambda first, *_, one: first.update(wrong=[]), "something else is right again"),
        (lambda first, *_, one: first.update(again=one["name"]), "KeyError"),
    ],
    ids=["an edge", "a name", "nobody", "one that is not over", "a name twice", "a suspect", "no suspect", "nobody is right"],
)
def test_a_forged_union_is_refused(doubtful, change, why, tmp_path):
    copy, more = Path(shutil.copytree(doubtful, tmp_path / "copy")), united(doubtful)
    (left,) = {one["name"] for one in lines_of(doubtful, ALTERNATIVES)[-3:]} - {one["again"] for one in more[:-1]}
    change(*more[:-1], one=more[-1])
    why, more[-1]["name"] = why.replace("13", left), more[-1]["name"].replace("13", left)
    forge(copy, ALTERNATIVES, lambda records: records.extend(more))
    assert why in refusal(copy)


def test_of_what_is_united_all_but_one_are_over(doubtful, tmp_path):
    copy, (first, second, union) = Path(shutil.copytree(doubtful, tmp_path / "copy")), united(doubtful)
    union["unites"] = [first["again"], second["again"]]
    forge(copy, ALTERNATIVES, lambda records: records.append(union))
    assert "united that are not over" in refusal(copy)


def test_what_else_is_heard_is_of_one_alternative_alone_and_its_robots_are_where_they_were_put(doubtful):
    log, known = Log(doubtful), Doubts(Log(doubtful)).main
    place = Start(log.starts[0].place, log.starts[0].heading)
    known._begin(replace(log.frames[0], readings={}, changes=[(0, place)]))
    add(known.edges, (-1, 0), (Fraction(1), Fraction(0)), Fraction(9))
    again = known.again(log.frames[0])
    add(again.edges, (-1, 0), (Fraction(1), Fraction(0)), Fraction(1))
    add(again.edges, (-1, 1), (Fraction(1), Fraction(0)), Fraction(1))
    again._slices[0] = again._looks[0] = again.sides._arcs[0] = None
    assert known.edges == {(-1, 0): {(Fraction(1), Fraction(0)): Fraction(9)}}
    assert not known._slices
    assert None not in known._looks
    assert not known.sides._arcs
    frame = again._instants[-1].frame
    assert frame.readings == log.frames[0].readings != {}
    assert frame.placed == {0: place}
