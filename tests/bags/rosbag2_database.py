"""A rosbag2 database as SQLite's own module writes it, for foreign_images.py and convert_bag.py."""
import sqlite3


def write_database(path, rows):
    """rows: topic, type, time of recording in nanoseconds, CDR of each message."""
    database = sqlite3.connect(path)
    database.executescript("""
        CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
        CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
          serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
          data BLOB NOT NULL);
        CREATE INDEX timestamp_idx ON messages (timestamp ASC);""")
    topics = {}
    for topic, kind, log_ns, data in rows:
        number = topics.setdefault(topic, len(topics) + 1)
        database.execute("INSERT OR IGNORE INTO topics VALUES(?, ?, ?, 'cdr', '')", (number, topic, kind))
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", (number, log_ns, data))
    database.commit()
    database.close()
