"""Recordings, read with the standard library alone: the same as Rerun's own reader says, and nothing where they are damaged."""

import struct

import numpy as np
import pyarrow as pa
import pytest
import rerun as rr
from helpers.proved.runs import lines_of, run_of
from helpers.recordings import rows_of
from hypothesis import given
from hypothesis import strategies as st

from experiments import prove
from experiments.proof.reading import MISSHAPEN, Broken
from experiments.proof.recording.arrow import Stream
from experiments.proof.recording.recorded import COMPONENTS, check_recording
from experiments.proof.recording.rrd import ALWAYS, CHUNK, ENTITY, chunks, recorded, unpacked
from experiments.proof.shown import Region
from filter import Frame

NAME = "moving_team.rrd"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return run_of(tmp_path_factory.mktemp("recorded"))


@pytest.mark.parametrize("layer", COMPONENTS)
def test_it_reads_what_reruns_own_reader_reads(folder, layer):
    found = recorded(folder / NAME, lambda name: name.startswith(layer))
    assert "/events" in found
    for robot in range(3):
        theirs = rows_of(folder / NAME, f"{layer}r{robot}", COMPONENTS[layer])
        ours = [row for row in found[f"{layer}r{robot}"] if row.step != ALWAYS]
        assert len(ours) == len(theirs) == 8
        for one, other in zip(ours, theirs, strict=True):
            assert (one.step, one.values[COMPONENTS[layer]]) == (other["step"], other["value"])
            assert one.time == pytest.approx(other["t"].total_seconds())


@given(st.binary(max_size=300), st.integers(1, 400), st.integers(0, 400))
def test_blocks_are_unpacked_as_they_were_packed(text, times, most):
    whole = text * times + text[:7]
    packed = pa.Codec("lz4_raw").compress(whole, asbytes=True) if whole else b"\0"
    assert unpacked(packed, len(whole)) == whole
    assert whole.startswith(unpacked(packed, most))
    assert len(unpacked(packed, most)) >= min(most, len(whole))


@given(st.binary(max_size=100))
def test_what_is_no_block_ends_in_an_error_or_in_bytes(text):
    try:
        assert isinstance(unpacked(text, 1000), bytes)
    except (Broken, *MISSHAPEN):
        pass


ARRAYS = {
    "int64": pa.array([1, None, -3], pa.int64()),
    "float": pa.array([1.5, 2.5], pa.float32()),
    "double": pa.array([1e300, None], pa.float64()),
    "bool": pa.array([True, None, False] * 5, pa.bool_()),
    "bytes": pa.array([b"a", b"", None, b"bcd"], pa.binary()),
    "lists": pa.array([[1.0, 2.0], [], None, [3.0]], pa.list_(pa.float64())),
    "points": pa.array([[[1.0, 2.0]], [], [[3.0, 4.0], [5.0, 6.0]]], pa.list_(pa.list_(pa.float32(), 2))),
    "durations": pa.array([1, 2], pa.int64()).cast(pa.duration("ns")),
    "nothing": pa.array([], pa.list_(pa.float64())),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_columns_come_back(name):
    table = pa.record_batch([ARRAYS[name]], pa.schema([pa.field(name, ARRAYS[name].type)], {"rerun:entity_path": "/a"}))
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as stream:
        stream.write_batch(table)
    found = Stream(sink.getvalue().to_pybytes())
    expected = ARRAYS[name] if name != "durations" else ARRAYS[name].cast(pa.int64())
    assert found.columns() == {name: expected.to_pylist()}
    assert found.notes == {ENTITY: "/a"}


def test_lists_that_overlap_are_refused():
    """Or few bytes could stand for very many."""
    table = pa.record_batch([pa.array([[1.0] * 8, [2.0], [3.0]], pa.list_(pa.float64()))], ["lists"])
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as stream:
        stream.write_batch(table)
    data, ends = sink.getvalue().to_pybytes(), struct.pack("<4i", 0, 8, 9, 10)
    assert Stream(data).columns() == {"lists": [[1.0] * 8, [2.0], [3.0]]}
    for others in ((0, 8, 0, 10), (0, 8, 9, 11), (-1, 8, 9, 10)):
        with pytest.raises(Broken, match="overlap"):
            Stream(data.replace(ends, struct.pack("<4i", *others))).columns()


def test_columns_of_other_types_are_refused():
    table = pa.record_batch([pa.array([1, 2], pa.timestamp("ns"))], ["when"])
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as stream:
        stream.write_batch(table)
    with pytest.raises(Broken, match="an Arrow type 10 that is not known here"):
        Stream(sink.getvalue().to_pybytes()).columns()


def varint(number):
    """Return a whole number as protocol buffers have it."""
    rest = bytearray()
    while number > 127:
        rest.append(number & 127 | 128)
        number >>= 7
    return bytes([*rest, number])


def literally(data):
    """Return an LZ4 block that repeats nothing."""
    more = len(data) - 15
    return bytes([0xF0, *([255] * (more // 255)), more % 255]) + data


def repacked(path, change, more=()):
    """Write a recording in which what `change` returns stands for the payloads of chunks, and more; None leaves one out."""
    whole, body = path.read_bytes(), b""
    for stream in (*(unpacked(*packed) for packed in chunks(whole)), *more):
        other = change(Stream(stream).notes[ENTITY], stream)
        if other is not None:
            block = literally(other)
            message = b"\x10\x02\x18" + varint(len(other)) + b"\x20\x01\x2a" + varint(len(block)) + block
            body += struct.pack("<QQ", CHUNK, len(message)) + message
    path.write_bytes(whole[:12] + body + struct.pack("<QQ", 0, 0))


def proved(folder, path):
    """Return how many regions are as a recording shows them, and how many entities are of no region."""
    lines = lines_of(folder, prove.REGIONS)
    regions = [
        [
            Region(
                [tuple(map(float.fromhex, vertex)) for vertex in one["vertices"]],
                float.fromhex(one["area"]),
                tuple(map(float.fromhex, one["estimate"])),
            )
            for one in line["regions"]
        ]
        for line in lines
    ]
    return check_recording(
        path, [f"r{robot}" for robot, _ in enumerate(regions[0])], [Frame(float.fromhex(line["t"])) for line in lines], regions
    )


@pytest.fixture
def copy(folder, tmp_path):
    (tmp_path / NAME).write_bytes((folder / NAME).read_bytes())
    return tmp_path / NAME


def test_a_recording_that_was_packed_anew_is_as_good(folder, copy):
    repacked(copy, lambda name, stream: stream)
    assert proved(folder, copy) == proved(folder, folder / NAME)
    assert proved(folder, copy)[0] == 24


@pytest.mark.parametrize("layer", COMPONENTS)
def test_another_number_is_noticed(folder, copy, layer):
    region = lines_of(folder, prove.REGIONS)[5]["regions"][1]
    number = float.fromhex(
        {"/area/": region["area"], "/world/estimate/": region["estimate"][0]}.get(layer, region["vertices"][1][0])
    )
    form = "<d" if layer == "/area/" else "<f"
    old, new = struct.pack(form, number), struct.pack(form, number * (1 + 1e-6))

    def change(name, stream):
        return stream.replace(old, new) if name == f"{layer}r1" else stream

    repacked(copy, change)
    with pytest.raises(Broken, match="are shown, where" if layer == "/area/" else "shows another polygon"):
        proved(folder, copy)


@pytest.mark.parametrize("layer", COMPONENTS)
def test_an_entity_that_is_missing_is_noticed(folder, copy, layer):
    repacked(copy, lambda name, stream: None if name == f"{layer}r2" else stream)
    with pytest.raises(Broken, match=f"{layer}r2 has 0 rows, where the log has 8 frames"):
        proved(folder, copy)


MORE = {
    "moved": ("/world/outer/r0", rr.Transform3D(translation=[5, 0, 0])),
    "moved, with all others": ("/world/outer", rr.Transform3D(scale=0.1)),
    "turned round": ("/world", rr.Transform3D(rotation_axis_angle=rr.RotationAxisAngle([0, 0, 1], 1.0))),
    "another line": ("/world/outer/r0", rr.LineStrips2D([[[0, 0], [0.1, 0]]])),
    "wiped": ("/world/outer/r0", rr.Clear(recursive=True)),
    "another mesh": ("/world/fill/r1", rr.Boxes3D(half_sizes=[[1, 1, 1]])),
}


@pytest.mark.parametrize("how", MORE)
def test_what_changes_how_a_region_is_shown_is_noticed(folder, copy, tmp_path, how):
    entity, archetype = MORE[how]
    with rr.RecordingStream("more", recording_id="more") as stream:
        stream.save(tmp_path / "more.rrd")
        stream.log(entity, archetype, static=True)
    streams = [unpacked(*packed) for packed in chunks((tmp_path / "more.rrd").read_bytes())]
    (more,) = (stream for stream in streams if Stream(stream).notes[ENTITY] == entity)
    repacked(copy, lambda name, stream: stream, [more])
    with pytest.raises(Broken, match=f"{entity} has columns|an Arrow type"):
        proved(folder, copy)


def test_a_triangle_elsewhere_is_noticed(folder, copy):
    old, new = struct.pack("<6I", 0, 1, 2, 0, 2, 3), struct.pack("<6I", 0, 1, 2, 0, 1, 3)
    repacked(copy, lambda name, stream: stream.replace(old, new) if name == "/world/fill/r1" else stream)
    with pytest.raises(Broken, match="fills another polygon"):
        proved(folder, copy)


@pytest.mark.parametrize("share", [0.0, 0.0001, 0.3, 0.99999])
def test_a_recording_that_is_cut_off_is_damaged(folder, copy, share):
    whole = copy.read_bytes()
    copy.write_bytes(whole[: int(share * len(whole)) - 64 * (share > 0.9)])
    with pytest.raises(Broken, match=NAME):
        proved(folder, copy)


@pytest.mark.parametrize("seed", range(20))
def test_bytes_that_are_others_are_no_traceback(folder, copy, seed):
    whole, rng = bytearray(copy.read_bytes()), np.random.default_rng(seed)
    for at in rng.integers(len(whole), size=20):
        whole[at] = rng.integers(256)
    copy.write_bytes(whole)
    try:
        assert proved(folder, copy)[0] == 24
    except Broken as error:
        assert str(error).startswith(NAME)
