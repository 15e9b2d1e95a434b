#!/usr/bin/env python3
"""Converts an MCAP bag of ROS 2 (without compression) by Debian's python3-rosbag and sqlite3.

  convert_bag.py ros1 IN.mcap OUT.bag COMPRESSION    a ROS 1 bag (none, lz4, bz2)
  convert_bag.py rosbag2 IN.mcap OUT                 a rosbag2 folder: metadata.yaml and two .db3 files
"""
import importlib
import os
import struct
import sys

from rosbag2_database import write_database

MAGIC = 8
SCHEMA, CHANNEL, MESSAGE, CHUNK = 3, 4, 5, 6


def records(data, start, end):
    while start + 9 <= end:
        kind, size = struct.unpack_from("<BQ", data, start)
        yield kind, start + 9, start + 9 + size
        start += 9 + size


def text(data, at):
    size = struct.unpack_from("<I", data, at)[0]
    return data[at + 4:at + 4 + size].decode(), at + 4 + size


def messages(path):
    """Topic, type, time of recording in nanoseconds, CDR of each message in the order of the file."""
    with open(path, "rb") as file:
        data = file.read()
    schemas, channels = {}, {}

    def scan(start, end):
        for kind, begin, finish in records(data, start, end):
            if kind == SCHEMA:
                schemas[struct.unpack_from("<H", data, begin)[0]] = text(data, begin + 2)[0]
            elif kind == CHANNEL:
                channel, schema = struct.unpack_from("<HH", data, begin)
                channels[channel] = (text(data, begin + 4)[0], schemas[schema])
            elif kind == MESSAGE:
                channel, _, log_ns, _ = struct.unpack_from("<HIQQ", data, begin)
                yield *channels[channel], log_ns, data[begin + 22:finish]
            elif kind == CHUNK:
                compression, at = text(data, begin + 28)
                if compression:
                    sys.exit("convert_bag.py: the bag is compressed")
                yield from scan(at + 8, finish)

    yield from scan(MAGIC, len(data) - MAGIC)


class Cdr:
    """Reads a message of ROS 2 into a message class of ROS 1: both have the same fields, except the header's seq."""
    FORMATS = {"bool": "?", "uint8": "B", "byte": "b", "char": "B", "int8": "b", "uint16": "H", "int16": "h",
               "uint32": "I", "int32": "i", "uint64": "Q", "int64": "q", "float32": "f", "float64": "d"}

    def __init__(self, data):
        self.order = "<" if data[1] else ">"
        self.data = data[4:]
        self.at = 0

    def primitive(self, kind, count=1):
        code = self.FORMATS[kind]
        size = struct.calcsize(code)
        if count > 0:
            self.at = (self.at + size - 1) // size * size
        values = struct.unpack_from("%s%d%s" % (self.order, count, code), self.data, self.at)
        self.at += size * count
        return values

    def value(self, kind):
        if kind.endswith("]"):
            kind, _, count = kind[:-1].partition("[")
            count = int(count) if count else self.primitive("uint32")[0]
            if kind in ("uint8", "char"):
                self.at += count
                return self.data[self.at - count:self.at]
            if kind in self.FORMATS:
                return list(self.primitive(kind, count))
            return [self.value(kind) for _ in range(count)]
        if kind in self.FORMATS:
            return self.primitive(kind)[0]
        if kind == "string":
            size = self.primitive("uint32")[0]
            self.at += size
            return self.data[self.at - size:self.at - 1].decode()
        if kind == "time":
            import genpy
            return genpy.Time(*self.primitive("int32"), *self.primitive("uint32"))
        return self.message(message_class(kind))

    def message(self, cls):
        message = cls()
        for name, kind in zip(cls.__slots__, cls._slot_types):
            if name != "seq":
                setattr(message, name, self.value(kind))
        return message


def message_class(kind):
    package, name = kind.split("/")
    return getattr(importlib.import_module(package + ".msg"), name)


def write_ros1(source, out, compression):
    import genpy
    import rosbag

    with rosbag.Bag(out, "w", compression=compression) as bag:
        for topic, kind, log_ns, data in messages(source):
            message = Cdr(data).message(message_class(kind.replace("/msg/", "/")))
            bag.write(topic, message, genpy.Time(*divmod(log_ns, 10**9)))


def write_rosbag2(source, out):
    rows = sorted(messages(source), key=lambda row: row[2])
    os.makedirs(out)
    name = os.path.basename(os.path.normpath(out))
    files = ["%s_%d.db3" % (name, part) for part in (0, 1)]
    middle = len(rows) // 2
    for file, part in zip(files, (rows[:middle], rows[middle:])):
        write_database(os.path.join(out, file), part)
    kinds = {topic: kind for topic, kind, _, _ in rows}
    with open(os.path.join(out, "metadata.yaml"), "w") as file:
        file.write("rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n")
        file.write("  duration:\n    nanoseconds: %d\n" % (rows[-1][2] - rows[0][2]))
        file.write("  starting_time:\n    nanoseconds_since_epoch: %d\n" % rows[0][2])
        file.write("  message_count: %d\n  topics_with_message_count:\n" % len(rows))
        for topic, kind in kinds.items():
            file.write("    - topic_metadata:\n        name: %s\n        type: %s\n" % (topic, kind))
            file.write("        serialization_format: cdr\n        offered_qos_profiles: \"\"\n")
            file.write("      message_count: %d\n" % sum(row[0] == topic for row in rows))
        file.write("  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n")
        file.writelines("    - %s\n" % path for path in files)


def main():
    command = sys.argv[1] if len(sys.argv) > 1 else ""
    if command == "ros1" and len(sys.argv) == 5:
        write_ros1(*sys.argv[2:])
    elif command == "rosbag2" and len(sys.argv) == 4:
        write_rosbag2(*sys.argv[2:])
    else:
        sys.exit(__doc__)


main()
