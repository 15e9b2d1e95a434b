// MCAP files of the images of foreign_images.py, written by @mcap/core and serialized by @foxglove/rosmsg2-serialization.
//   node foreign_mcap.mjs DIR OUT none|zstd|lz4 [loose|unindexed]
// loose: messages without chunks; unindexed: without a summary. DIR/messages.bin gets the serialized messages, each after
// its length.
import { McapWriter } from "@mcap/core";
import { parse } from "@foxglove/rosmsg";
import { MessageWriter } from "@foxglove/rosmsg2-serialization";
import zstd from "@foxglove/wasm-zstd";
import lz4 from "lz4js";
import { appendFileSync, closeSync, openSync, readFileSync, writeFileSync, writeSync } from "node:fs";
import { join } from "node:path";

const [folder, out, compression, form] = process.argv.slice(2);
const header = `std_msgs/Header header\n`;
const definitions = `================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
`;
const types = {
  "sensor_msgs/msg/Image":
    `${header}uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n${definitions}`,
  "sensor_msgs/msg/CompressedImage": `${header}string format\nuint8[] data\n${definitions}`,
};

class Output {
  constructor(path) {
    this.file = openSync(path, "w");
    this.size = 0n;
  }
  position() {
    return this.size;
  }
  async write(bytes) {
    writeSync(this.file, bytes);
    this.size += BigInt(bytes.byteLength);
  }
}

await zstd.isLoaded;
const compressors = {
  none: undefined,
  zstd: (bytes) => ({ compression: "zstd", compressedData: zstd.compress(bytes) }),
  lz4: (bytes) => ({ compression: "lz4", compressedData: lz4.compress(bytes) }),
};
const output = new Output(out);
const unindexed = form === "unindexed";
const writer = new McapWriter({
  writable: output,
  compressChunk: compressors[compression],
  chunkSize: 20000,
  useChunks: form !== "loose",
  useStatistics: !unindexed,
  useSummaryOffsets: !unindexed,
  useChunkIndex: !unindexed,
  useMessageIndex: !unindexed,
  repeatChannels: !unindexed,
  repeatSchemas: !unindexed,
  startChannelId: 1,
});
await writer.start({ profile: "ros2", library: "test" });
const serializers = {};
const channels = {};
const serialized = join(folder, "messages.bin");
writeFileSync(serialized, "");
for (const image of JSON.parse(readFileSync(join(folder, "images.json"), "utf8"))) {
  const type = image.compressed ? "sensor_msgs/msg/CompressedImage" : "sensor_msgs/msg/Image";
  if (serializers[type] === undefined) {
    const data = new TextEncoder().encode(types[type]);
    const schemaId = await writer.registerSchema({ name: type, encoding: "ros2msg", data });
    serializers[type] = { schemaId, message: new MessageWriter(parse(types[type], { ros2: true })) };
  }
  const { schemaId, message } = serializers[type];
  channels[image.topic] ??= await writer.registerChannel({
    schemaId, topic: image.topic, messageEncoding: "cdr", metadata: new Map(),
  });
  const data = message.writeMessage({
    header: { stamp: { sec: image.seconds, nanosec: image.nanoseconds }, frame_id: "camera" },
    height: image.height, width: image.width, encoding: image.encoding, is_bigendian: image.is_bigendian,
    step: image.step, format: image.encoding, data: readFileSync(join(folder, image.file)),
  });
  const length = new Uint8Array(new Uint32Array([data.byteLength]).buffer);
  appendFileSync(serialized, length);
  appendFileSync(serialized, data);
  const time = BigInt(image.seconds) * 1000000000n + BigInt(image.nanoseconds);
  await writer.addMessage({ channelId: channels[image.topic], sequence: 0, logTime: time, publishTime: time, data });
}
await writer.end();
closeSync(output.file);
