// Validates an MCAP file by the readers of its authors. Called by validate-mcap.sh.
//   node validate-mcap.mjs messages BAG.mcap               the bag of tests/app/bags/write_bag.cpp
//   node validate-mcap.mjs trajectory T.mcap T.tum S.csv   of one localization
//   node validate-mcap.mjs mapped T.mcap T.tum             of one recording that was mapped
//   node validate-mcap.mjs map MAP.mcap MAP.tum GRID.pgm   exports of one map; the picture is that of --format png
import assert from "node:assert/strict";
import fs from "node:fs";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import rosmsg from "@foxglove/rosmsg";
import rosmsg2 from "@foxglove/rosmsg2-serialization";
import common from "@foxglove/rosmsg-msgs-common";
import zstd from "@foxglove/wasm-zstd";
import lz4 from "@foxglove/wasm-lz4";

const kMagicLength = 8;
const kDataEnd = 0x0f;

async function Decompressors() {
  await zstd.isLoaded;
  await lz4.isLoaded;
  return {
    zstd: (bytes, size) => zstd.decompress(bytes, Number(size)),
    lz4: (bytes, size) => lz4(bytes, Number(size)),
  };
}

// CRC-32 of zlib.
function Crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

// Opcode, offset and content of the records outside of chunks.
function* TopRecords(file) {
  for (let at = kMagicLength; at < file.length - kMagicLength; ) {
    const length = Number(file.readBigUInt64LE(at + 1));
    yield { opcode: file[at], at, content: file.subarray(at + 9, at + 9 + length) };
    at += 9 + length;
  }
}

// Neither reader compares the CRC of the data section.
function CheckDataCrc(file) {
  const end = [...TopRecords(file)].find((record) => record.opcode === kDataEnd);
  assert.equal(end.content.readUInt32LE(0), Crc32(file.subarray(0, end.at)), "CRC of the data section");
}

// Record by record, with the CRC of each chunk.
function ReadStream(file, decompressHandlers) {
  const reader = new McapStreamReader({ includeChunks: true, decompressHandlers, validateCrcs: true });
  reader.append(file);
  const counts = {};
  for (let record; (record = reader.nextRecord()); ) counts[record.type] = (counts[record.type] ?? 0) + 1;
  assert.ok(reader.done(), "the stream reader reaches the end");
  assert.equal(reader.bytesRemaining(), 0);
  return counts;
}

// By the summary, whose CRC Initialize compares.
async function OpenIndexed(file, decompressHandlers) {
  const readable = {
    size: async () => BigInt(file.length),
    read: async (offset, size) => file.subarray(Number(offset), Number(offset + size)),
  };
  return await McapIndexedReader.Initialize({ readable, decompressHandlers });
}

// The embedded definition equals that of ROS 2, type by type.
function CheckDefinitions(name, parsed) {
  for (const ours of parsed) {
    const key = (ours.name ?? name).replace("/msg/", "/");
    for (const release of ["ros2humble", "ros2jazzy"]) {
      const theirs = common[release][key];
      assert.ok(theirs, `${release} has ${key}`);
      const fields = (definition) =>
        definition.definitions.map(({ type, name, isArray, arrayLength, isConstant, value, defaultValue, isComplex }) => ({
          type: type.replace("/msg/", "/"), name, isArray: isArray ?? false, arrayLength, isConstant: isConstant ?? false,
          value, defaultValue, isComplex: isComplex ?? false,
        }));
      assert.deepEqual(fields(ours), fields(theirs), `${key} of ${release}`);
    }
  }
}

// All messages in order of time: {topic, type, time (ns), value}.
async function ReadMessages(reader) {
  const decoders = new Map();
  for (const channel of reader.channelsById.values()) {
    assert.equal(channel.messageEncoding, "cdr");
    const schema = reader.schemasById.get(channel.schemaId);
    assert.equal(schema.encoding, "ros2msg");
    const parsed = rosmsg.parse(new TextDecoder().decode(schema.data), { ros2: true });
    CheckDefinitions(schema.name, parsed);
    decoders.set(channel.id, { topic: channel.topic, type: schema.name, decoder: new rosmsg2.MessageReader(parsed) });
  }
  const messages = [];
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic, type, decoder } = decoders.get(message.channelId);
    messages.push({ topic, type, time: message.logTime, value: decoder.readMessage(message.data) });
  }
  return messages;
}

export async function Read(path) {
  const file = fs.readFileSync(path);
  const handlers = await Decompressors();
  CheckDataCrc(file);
  const counts = ReadStream(file, handlers);
  const reader = await OpenIndexed(file, handlers);
  const messages = await ReadMessages(reader);
  assert.equal(reader.header.profile, "ros2");
  assert.equal(BigInt(messages.length), reader.statistics.messageCount);
  assert.equal(counts.Chunk ?? 0, reader.statistics.chunkCount);
  assert.equal(reader.chunkIndexes.length, reader.statistics.chunkCount);
  for (const channel of reader.channelsById.values()) {
    const count = messages.filter((message) => message.topic === channel.topic).length;
    assert.equal(reader.statistics.channelMessageCounts.get(channel.id), BigInt(count), channel.topic);
  }
  const metadata = [];
  for await (const record of reader.readMetadata()) metadata.push(record);
  assert.deepEqual(metadata.map(({ name, metadata }) => [name, [...metadata]]), [["rosbag2", [["ROS_DISTRO", "humble"]]]]);
  return { reader, messages, counts };
}

const kStamp = { sec: 1700000000, nanosec: 123456789 };
const kPose = {
  position: { x: 1.5, y: -2.25, z: 3.125 },
  orientation: { x: 0.5, y: -0.5, z: 0.5, w: -0.5 },
};
const kTransform = { translation: kPose.position, rotation: kPose.orientation };
const kHeader = { stamp: kStamp, frame_id: "frame" };
const kPixels = [0, 1, 127, 128, 254, 255];
const kNothing = { x: 0, y: 0, z: 0 };
const Counted = (length, first) => Array.from({ length }, (_, i) => first + 0.25 * i);
const NotMeasured = () => [-1, 0, 0, 0, 0, 0, 0, 0, 0];

// As in tests/app/bags/all_messages.hpp.
const kExpected = {
  "/image": { header: kHeader, height: 2, width: 3, encoding: "mono8", is_bigendian: 0, step: 3, data: kPixels },
  "/compressed": { header: kHeader, format: "jpeg", data: kPixels },
  "/camera_info": {
    header: kHeader, height: 480, width: 640, distortion_model: "plumb_bob", d: [-0.3, 0.1, 0.001, -0.002, 0.05],
    k: Counted(9, 300), r: [1, 0, 0, 0, 1, 0, 0, 0, 1],
    p: [300, 300.25, 300.5, 0, 300.75, 301, 301.25, 0, 301.5, 301.75, 302, 0],
    binning_x: 0, binning_y: 0, roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false },
  },
  "/odom": {
    header: kHeader, child_frame_id: "child", pose: { pose: kPose, covariance: Counted(36, 1) },
    twist: {
      twist: { linear: { x: 0.1, y: 0.2, z: 0.3 }, angular: { x: 0.4, y: 0.5, z: 0.6 } }, covariance: Counted(36, -50),
    },
  },
  "/imu": {
    header: kHeader, orientation: { x: 0, y: 0, z: 0, w: 1 }, orientation_covariance: NotMeasured(),
    angular_velocity: { x: 0.01, y: -0.02, z: 0.03 }, angular_velocity_covariance: Array(9).fill(0),
    linear_acceleration: kNothing, linear_acceleration_covariance: NotMeasured(),
  },
  "/tf": {
    transforms: [
      { header: kHeader, child_frame_id: "child", transform: kTransform },
      {
        header: { stamp: { sec: 7, nanosec: 1 }, frame_id: "x" }, child_frame_id: "a longer name", transform: kTransform,
      },
    ],
  },
  "/pose": { header: kHeader, pose: { pose: kPose, covariance: Counted(36, 1) } },
  "/path": {
    header: kHeader,
    poses: [
      { header: { stamp: { sec: 0, nanosec: 1 }, frame_id: "" }, pose: kPose },
      { header: kHeader, pose: { position: kNothing, orientation: { x: 0, y: 0, z: 0, w: 1 } } },
    ],
  },
  "/map": {
    header: kHeader,
    info: { map_load_time: kStamp, resolution: Math.fround(0.05), width: 2, height: 3, origin: kPose },
    data: [0, 1, 50, 99, 100, -1],
  },
  "/diagnostics": {
    header: kHeader,
    status: [
      {
        level: 0, name: "localization", message: "tracking", hardware_id: "camera",
        values: [{ key: "peak", value: "0.512" }, { key: "empty", value: "" }],
      },
      { level: 2, name: "second", message: "", hardware_id: "", values: [] },
    ],
  },
};

// Plain objects, arrays instead of typed arrays, times as ROS 2 names them.
function Plain(value) {
  if (ArrayBuffer.isView(value) || Array.isArray(value)) return Array.from(value, Plain);
  if (value === null || typeof value !== "object") return value;
  const plain = {};
  for (const [key, field] of Object.entries(value)) plain[key === "nsec" ? "nanosec" : key] = Plain(field);
  return plain;
}

const Near = (a, b, tolerance, what) => assert.ok(Math.abs(a - b) <= tolerance, `${what}: ${a} and ${b}`);
const SecondsOf = (stamp) => stamp.sec + 1e-9 * stamp.nanosec;
const On = (messages, topic) => messages.filter((message) => message.topic === topic).map(({ value }) => Plain(value));

const ReadTable = (path, separator) =>
  fs.readFileSync(path, "utf8").split("\n").filter((line) => line !== "" && !line.startsWith("#"))
    .map((line) => line.split(separator));

// /pose and /tf have the poses of the TUM file, and no others.
function CheckPoses(messages, tum) {
  const lines = ReadTable(tum, " ").map((line) => line.map(Number));
  const poses = On(messages, "/pose");
  const transforms = On(messages, "/tf");
  assert.equal(poses.length, lines.length);
  assert.equal(transforms.length, lines.length);
  lines.forEach(([stamp, x, y, z, qx, qy, qz, qw], i) => {
    const { header, pose } = poses[i];
    assert.equal(header.frame_id, "map");
    Near(SecondsOf(header.stamp), stamp, 6e-7, "stamp");
    for (const [axis, value] of Object.entries({ x, y, z })) Near(pose.pose.position[axis], value, 1e-9, axis);
    for (const [axis, value] of Object.entries({ x: qx, y: qy, z: qz, w: qw })) {
      Near(pose.pose.orientation[axis], value, 1e-11, `quaternion ${axis}`);
    }
    const [transform] = transforms[i].transforms;
    assert.deepEqual(transform.header, header);
    assert.equal(transform.child_frame_id, "base_link");
    assert.deepEqual(transform.transform, { translation: pose.pose.position, rotation: pose.pose.orientation });
  });
  return poses;
}

const LevelOf = { tracking: 0, relocalized: 1, predicted: 1, ambiguous: 1, lost: 2 };

// Levels and names of /diagnostics; returns the number of frames by status.
function CheckDiagnostics(messages) {
  const counts = {};
  for (const { status } of On(messages, "/diagnostics")) {
    assert.equal(status.length, 1);
    assert.equal(status[0].name, "ceilmap");
    assert.equal(status[0].level, LevelOf[status[0].message]);
    counts[status[0].message] = (counts[status[0].message] ?? 0) + 1;
  }
  return counts;
}

const Told = (counts) => Object.entries(counts).map(([status, count]) => `${count} ${status}`).join(", ");

const kModes = {
  async trajectory([bag, tum, csv]) {
    const { messages } = await Read(bag);
    const poses = CheckPoses(messages, tum);
    const counts = CheckDiagnostics(messages);
    const [columns, ...rows] = ReadTable(csv, ",");
    const diagnostics = On(messages, "/diagnostics");
    assert.equal(diagnostics.length, rows.length);
    let next = 0;
    rows.forEach((row, i) => {
      const line = Object.fromEntries(columns.map((name, column) => [name, row[column]]));
      const { header, status: [status] } = diagnostics[i];
      Near(SecondsOf(header.stamp), Number(line.timestamp), 6e-7, "stamp");
      assert.equal(status.message, line.status);
      if (line.x === "") return;
      const values = Object.fromEntries(status.values.map(({ key, value }) => [key, value]));
      for (const key of ["peak", "inliers", "sigma_x", "sigma_y", "sigma_yaw_deg"]) assert.equal(values[key], line[key], key);
      for (const key of ["pitch_deg", "roll_deg"]) Near(Number(values[key]), Number(line[key]), 1e-9, key);
      const { covariance } = poses[next++].pose;
      Near(Math.sqrt(covariance[0]), Number(line.sigma_x), 6e-7, "sigma x");
      Near(Math.sqrt(covariance[7]), Number(line.sigma_y), 6e-7, "sigma y");
      Near((Math.sqrt(covariance[35]) * 180) / Math.PI, Number(line.sigma_yaw_deg), 6e-6, "sigma yaw");
    });
    assert.equal(next, poses.length);
    return `${poses.length} poses as in TUM and CSV; ${Told(counts)}`;
  },

  async mapped([bag, tum]) {
    const { messages } = await Read(bag);
    const poses = CheckPoses(messages, tum);
    return `${poses.length} poses as in TUM; ${Told(CheckDiagnostics(messages))}`;
  },

  async map([bag, tum, picture]) {
    const { reader, messages } = await Read(bag);
    CheckPoses(messages, tum);
    for (const { topic, metadata } of reader.channelsById.values()) {
      const latched = topic === "/map" || topic === "/keyframes";
      const durability = /durability: (\d)/.exec(metadata.get("offered_qos_profiles"))[1];
      assert.equal(durability, latched ? "1" : "2", topic);
    }
    const [grid] = On(messages, "/map");
    const { width, height, resolution, origin } = grid.info;
    const pgm = fs.readFileSync(picture);
    const head = /^P5\s(\d+)\s(\d+)\s255\s/.exec(pgm.subarray(0, 50).toString("latin1"));
    assert.deepEqual([width, height], [Number(head[1]), Number(head[2])]);
    for (let row = 0; row < height; row++) {
      for (let column = 0; column < width; column++) {
        const cell = grid.data[(height - 1 - row) * width + column];
        const grey = pgm[head[0].length + row * width + column];
        if (cell >= 0) Near(cell, ((255 - grey) * 100) / 255, 0.5, `cell ${column}, ${row}`);
      }
    }
    const unknown = grid.data.filter((cell) => cell < 0).length;
    const [path] = On(messages, "/keyframes");
    return `/map ${width} x ${height} cells of ${resolution.toFixed(4)} m from (${origin.position.x.toFixed(2)}, ` +
      `${origin.position.y.toFixed(2)}), as the picture, ${unknown} unknown; /keyframes ${path.poses.length}`;
  },

  async messages([bag]) {
    const { messages, counts } = await Read(bag);
    assert.deepEqual(messages.map(({ topic }) => topic), Object.keys(kExpected));
    messages.forEach(({ topic, time, value }, i) => {
      assert.equal(time, 1700000000123456789n + BigInt(i) * 1000000n);
      assert.deepEqual(Plain(value), kExpected[topic], topic);
    });
    return `${messages.length} messages in ${counts.Chunk} chunks: all fields as written`;
  },
};

const [mode, ...words] = process.argv.slice(2);
console.log(`${words[0].split("/").pop()}: ${await kModes[mode](words)}`);
