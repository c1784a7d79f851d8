"""Makes small recordings, of ROS 1 and of ROS 2 as MCAP or sqlite3, from messages of which only what matters is told."""

import sqlite3

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

FORMS = ("bag", "mcap", "db3")
PLUGINS = {"mcap": StoragePlugin.MCAP, "db3": StoragePlugin.SQLITE3}


def write_bag(path, said, definitions=None):
    """Write (topic, type, time of receipt [ns], fields) to path.bag, path.mcap or the folder path.db3; return the path."""
    form = path.suffix[1:]
    store = get_typestore(Stores.ROS1_NOETIC if form == "bag" else Stores.ROS2_HUMBLE)
    for name, text in (definitions or {}).items():
        store.register(get_types_from_msg(text, name))
    writer = Writer1(path) if form == "bag" else Writer2(path.with_suffix(f".{form}_"), version=8, storage_plugin=PLUGINS[form])
    serialize = store.serialize_ros1 if form == "bag" else store.serialize_cdr
    with writer:
        connections = {
            (topic, kind): writer.add_connection(topic, kind, typestore=store)
            for topic, kind in dict.fromkeys(each[:2] for each in said)
        }
        for topic, kind, received, fields in said:
            writer.write(connections[topic, kind], received, serialize(made(store, kind, fields), kind))
    if form == "mcap":
        next(writer.path.glob("*.mcap")).replace(path)
    return path if form in ("bag", "mcap") else writer.path


def without_definitions(folder):
    """Take the definitions out of a folder of rosbag2 by sqlite3, as older recorders wrote none; return the file in it."""
    (file,) = folder.glob("*.db3")
    with sqlite3.connect(file) as database:
        database.execute("DELETE FROM message_definitions")
    database.close()
    return file


def stamped(time, **fields):
    """Return fields with a header of a time [ns]."""
    return {"header": {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}}, **fields}


def turned(yaw):
    return {"z": float(np.sin(yaw / 2)), "w": float(np.cos(yaw / 2))}


def made(store, kind, fields):
    """Return a message; what is not told is 0, empty, or False."""
    declared = store.fielddefs[kind][1]
    assert set(fields) <= {name for name, _ in declared}, (kind, fields)
    return store.types[kind](**{name: _field(store, sort, fields.get(name)) for name, sort in declared})


def _field(store, sort, value):
    node, inner = sort
    if node == Nodetype.NAME:
        return made(store, inner, value or {})
    if node == Nodetype.BASE:
        plain = "" if inner[0] == "string" else 0.0 if inner[0].startswith("float") else 0
        return plain if value is None else value
    (node, kind), length = inner
    if node == Nodetype.NAME:
        return [made(store, kind, each) for each in value or []]
    if kind[0] == "string":
        return list(value or [])
    return np.array([0] * length if value is None else value, dtype=kind[0])
