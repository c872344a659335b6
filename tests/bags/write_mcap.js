// SPDX-License-Identifier: MIT
// write_mcap.js PLAN.json: writes MCAP files with npm's @mcap/core and @foxglove/rosmsg2-serialization. The plan names the
// messages, whose pixels lie in files, and the files to write; LZ4 and Zstandard are those of the commands lz4 and zstd.
import { execFileSync } from "node:child_process";
import { closeSync, openSync, readFileSync, writeSync } from "node:fs";
import { McapWriter } from "@mcap/core";
import { parse } from "@foxglove/rosmsg";
import { MessageWriter } from "@foxglove/rosmsg2-serialization";

const HEADER = `
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
`;
const DEFINITIONS = {
  Image: `std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
${HEADER}`,
  CompressedImage: `std_msgs/Header header
string format
uint8[] data
${HEADER}`,
  CameraInfo: `std_msgs/Header header
uint32 height
uint32 width
string distortion_model
float64[] d
float64[9] k
float64[9] r
float64[12] p
uint32 binning_x
uint32 binning_y
sensor_msgs/RegionOfInterest roi
${HEADER}
================================================================================
MSG: sensor_msgs/RegionOfInterest
uint32 x_offset
uint32 y_offset
uint32 height
uint32 width
bool do_rectify
`,
};
const COMPRESS = {
  lz4: (data) => execFileSync("lz4", ["-c", "-q", "-"], { input: data, maxBuffer: 1 << 28 }),
  zstd: (data) => execFileSync("zstd", ["-c", "-q", "-"], { input: data, maxBuffer: 1 << 28 }),
};

class File {
  constructor(path) {
    this.file = openSync(path, "w");
    this.at = 0n;
  }
  position() {
    return this.at;
  }
  async write(bytes) {
    writeSync(this.file, bytes);
    this.at += BigInt(bytes.byteLength);
  }
}

async function writeFile({ path, compression, indexed, chunks, messages }) {
  const file = new File(path);
  const compress = COMPRESS[compression];
  const writer = new McapWriter({
    writable: file,
    useChunks: chunks,
    useStatistics: indexed,
    useSummaryOffsets: indexed,
    useMessageIndex: indexed,
    useChunkIndex: indexed,
    repeatChannels: indexed,
    repeatSchemas: indexed,
    chunkSize: 300_000,
    compressChunk: compress && ((data) => ({ compression, compressedData: compress(data) })),
  });
  await writer.start({ profile: "ros2", library: "test" });
  const channels = new Map();
  for (const [sequence, message] of messages.entries()) {
    const writers = new MessageWriter(parse(DEFINITIONS[message.type], { ros2: true }));
    if (!channels.has(message.topic)) {
      const schemaId = await writer.registerSchema({
        name: `sensor_msgs/msg/${message.type}`,
        encoding: "ros2msg",
        data: new TextEncoder().encode(DEFINITIONS[message.type]),
      });
      channels.set(
        message.topic,
        await writer.registerChannel({ schemaId, topic: message.topic, messageEncoding: "cdr", metadata: new Map() }),
      );
    }
    const time = BigInt(message.stamp);
    const stamp = { sec: Number(time / 1_000_000_000n), nanosec: Number(time % 1_000_000_000n) };
    const fields = { ...message.fields, header: { stamp, frame_id: "camera" } };
    if (message.data) fields.data = new Uint8Array(readFileSync(message.data));
    await writer.addMessage({
      channelId: channels.get(message.topic),
      sequence,
      logTime: time + 1_000_000n,
      publishTime: time,
      data: writers.writeMessage(fields),
    });
  }
  await writer.end();
  closeSync(file.file);
}

for (const file of JSON.parse(readFileSync(process.argv[2], "utf8"))) await writeFile(file);
