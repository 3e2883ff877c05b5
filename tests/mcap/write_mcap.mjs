// Writes a recording as MCAP files, through the libraries of those who made the format.
//   node write_mcap.mjs NODE_MODULES RECORDING.json
// The JSON has width, height, images [{t_ns, gray: file of bytes}] and poses [{t_ns, pose: x y z qx qy qz qw}]. Written
// beside it: unchunked, chunked, lz4, zstd and noindex.mcap.
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";

const [modules, recordingPath] = process.argv.slice(2);
const require = createRequire(join(modules, "of-the-test.js"));
const { McapWriter, TempBuffer } = require("@mcap/core");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { parse } = require("@foxglove/rosmsg");
const lz4 = require("lz4js");
const { ZstdCodec } = require("zstd-codec");

const HEADER = `std_msgs/Header header
`;
const HEADER_TYPES = `
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
`;
const IMAGE = `${HEADER}uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data${HEADER_TYPES}`;
const POSE = `${HEADER}geometry_msgs/Pose pose
================================================================================
MSG: geometry_msgs/Pose
geometry_msgs/Point position
geometry_msgs/Quaternion orientation
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w${HEADER_TYPES}`;

const folder = dirname(recordingPath);
const recording = JSON.parse(readFileSync(recordingPath, "utf8"));
const zstd = await new Promise((resolve) => ZstdCodec.run((codec) => resolve(new codec.Simple())));

const headerOf = (t) => ({
  stamp: { sec: Number(t / 1000000000n), nanosec: Number(t % 1000000000n) },
  frame_id: "camera",
});

// Every message in order of time, as [topic, t_ns, value].
const messages = [
  ...recording.images.map(({ t_ns, gray }) => {
    const t = BigInt(t_ns);
    const data = new Uint8Array(readFileSync(join(folder, gray)));
    const { width, height } = recording;
    const image = { header: headerOf(t), height, width, encoding: "mono8", is_bigendian: 0, step: width, data };
    return ["/camera/image_raw", t, image];
  }),
  ...recording.poses.map(({ t_ns, pose: [x, y, z, qx, qy, qz, qw] }) => {
    const t = BigInt(t_ns);
    const pose = { position: { x, y, z }, orientation: { x: qx, y: qy, z: qz, w: qw } };
    return ["/body/pose", t, { header: headerOf(t), pose }];
  }),
].sort((a, b) => (a[1] < b[1] ? -1 : a[1] > b[1] ? 1 : 0));

async function write(name, options) {
  const buffer = new TempBuffer();
  const writer = new McapWriter({ writable: buffer, ...options });
  await writer.start({ profile: "ros2", library: "test" });
  const channels = {};
  for (const [topic, type, text] of [
    ["/camera/image_raw", "sensor_msgs/msg/Image", IMAGE],
    ["/body/pose", "geometry_msgs/msg/PoseStamped", POSE],
  ]) {
    const schemaId = await writer.registerSchema({ name: type, encoding: "ros2msg", data: Buffer.from(text) });
    const channel = { topic, schemaId, messageEncoding: "cdr", metadata: new Map() };
    const id = await writer.registerChannel(channel);
    channels[topic] = { id, serialise: new MessageWriter(parse(text, { ros2: true })) };
  }
  for (const [sequence, [topic, t, value]] of messages.entries()) {
    const { id, serialise } = channels[topic];
    const logTime = t + 5000000n;
    const data = serialise.writeMessage(value);
    await writer.addMessage({ channelId: id, sequence, logTime, publishTime: t, data });
  }
  await writer.end();
  writeFileSync(join(folder, name), buffer.get());
}

const noIndex = {
  useStatistics: false,
  useSummaryOffsets: false,
  useChunkIndex: false,
  useMessageIndex: false,
  repeatSchemas: false,
  repeatChannels: false,
};
await write("unchunked.mcap", { useChunks: false });
await write("chunked.mcap", { chunkSize: 200000 });
await write("lz4.mcap", {
  chunkSize: 200000,
  compressChunk: (data) => ({ compression: "lz4", compressedData: new Uint8Array(lz4.compress(data)) }),
});
await write("zstd.mcap", {
  chunkSize: 200000,
  compressChunk: (data) => ({ compression: "zstd", compressedData: zstd.compress(data, 3) }),
});
await write("noindex.mcap", { chunkSize: 200000, ...noIndex });
