// Foxglove's own client over the WebSocket and @mcap/core over the file read what states.csv has; so does whoever
// listens for datagrams. node streams_test.js PROGRAMS; NODE_PATH and exit status 77 as of streams.js.
"use strict";
const assert = require("node:assert");
const { spawn, spawnSync } = require("node:child_process");
const dgram = require("node:dgram");
const fs = require("node:fs");
const path = require("node:path");
const { mcap, programs, folder, at, rowsOf, keyOf, followFoxglove, readMcap, countTopics } = require("./streams.js");

const COLUMNS = {
  position: ["x", "y", "z"], orientation: ["qx", "qy", "qz", "qw"], linear_velocity: ["vx_world", "vy_world", "vz_world"],
  angular_velocity: ["wx_body", "wy_body", "wz_body"],
  sigma: ["rx", "ry", "rz", "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"].map((name) => "sigma_" + name),
};

const statesCsv = () => new Map(rowsOf("out/states.csv").map((row) => [row.t, row]));

// Numbers of a state message are those of its row; returns how many were compared.
function checkState(state, rows) {
  const row = rows.get(keyOf(state.stamp));
  assert(row, "no row at " + keyOf(state.stamp));
  assert.strictEqual(state.status, row.status);
  assert.strictEqual(String(state.n_tags), row.n_tags);
  let n = 0;
  for (const [key, columns] of Object.entries(COLUMNS)) {
    columns.forEach((column, i) => {
      if (row[column] === "") assert.strictEqual(state[key], null);
      else assert.strictEqual(state[key][i], Number(row[column]), column);
      n++;
    });
  }
  return n;
}

function checkMessage(topic, message, rows) {
  const xyz = (vector, columns, row) => columns.forEach((c, i) => assert.strictEqual(vector["xyzw"[i]], Number(row[c]), c));
  if (topic === "/tagtwist/body/state") return checkState(message, rows);
  if (topic === "/tagtwist/body/pose") {
    const row = rows.get(keyOf(message.timestamp));
    assert.strictEqual(message.frame_id, "world");
    xyz(message.pose.position, COLUMNS.position, row);
    xyz(message.pose.orientation, COLUMNS.orientation, row);
  } else if (topic === "/tagtwist/body/twist") {
    const row = rows.get(keyOf(message.timestamp));
    xyz(message.linear, COLUMNS.linear_velocity, row);
    xyz(message.angular, COLUMNS.angular_velocity, row);
  } else if (topic === "/tf") {
    const [body, camera] = message.transforms;
    assert.deepStrictEqual([body.parent_frame_id, body.child_frame_id, camera.child_frame_id], ["world", "body", "cam0"]);
    xyz(body.translation, COLUMNS.position, rows.get(keyOf(body.timestamp)));
  } else if (topic === "/tagtwist/body/cam0/image") {
    const jpeg = Buffer.from(message.data, "base64");
    assert.strictEqual(jpeg.readUInt16BE(0), 0xffd8);
    assert.strictEqual(jpeg.readUInt16BE(jpeg.length - 2), 0xffd9);
    assert(rows.has(keyOf(message.timestamp)));
  } else if (topic === "/tagtwist/map") {
    assert.strictEqual(message.entities[0].texts.length, 108);
  } else {
    assert.fail(topic);
  }
  return 1;
}

function run(args, onLine) {
  return new Promise((resolve, reject) => {
    const program = spawn(path.join(programs, "tagtwist_estimate"), args, { cwd: folder });
    let error = "", rest = "";
    program.stderr.on("data", (data) => (error += data));
    program.stdout.on("data", (data) => {
      rest += data;
      const lines = rest.split("\n");
      rest = lines.pop();
      lines.forEach(onLine);
    });
    program.on("exit", (status) => (status === 0 ? resolve(error) : reject(new Error("status " + status + ": " + error))));
  });
}

// As Foxglove seeks: by the index at the file's end, messages of some topics from some time on.
async function readIndexed(name, args) {
  const bytes = fs.readFileSync(at(name));
  const readable = { size: async () => BigInt(bytes.length),
    read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)) };
  const reader = await mcap.McapIndexedReader.Initialize({ readable });
  const out = [];
  for await (const message of reader.readMessages(args)) {
    out.push([reader.channelsById.get(message.channelId).topic, JSON.parse(Buffer.from(message.data).toString())]);
  }
  return { messages: out, reader };
}

// What a run that is killed has written is there, to the last message.
async function checkKilled() {
  const written = () => (fs.existsSync(at("killed.csv")) ? fs.readFileSync(at("killed.csv"), "utf8").split("\n").length - 2 : 0);
  const program = spawn(path.join(programs, "tagtwist_estimate"), ["--dataset", "flight", "--sliding_window", "--realtime", "--output",
    "killed", "--publish", "mcap:killed.mcap", "--publish", "csv:killed.csv"], { cwd: folder, stdio: "ignore" });
  const gone = new Promise((resolve) => program.on("exit", resolve));
  while (written() < 50 && program.exitCode === null) await new Promise((resolve) => setTimeout(resolve, 5));
  program.kill("SIGKILL");
  await gone;
  const rows = written(), killed = readMcap("killed.mcap"), states = countTopics(killed.messages)["/tagtwist/body/state"];
  console.log("mcap, killed:", states, "of", rows, "frames");
  assert(rows >= 50 && !killed.done && states > rows - 10);
}

async function main() {
  const rate = 30, seconds = 4;
  const made = spawnSync(path.join(programs, "tagtwist_simulate"), ["--output", "flight", "--trajectory", "hover", "--rate", String(rate),
    "--duration", String(seconds), "--imu_rate", "0"], { cwd: folder });
  assert.strictEqual(made.status, 0, String(made.stderr));

  const socket = dgram.createSocket("udp4"), datagrams = [];
  await new Promise((resolve) => socket.bind(0, "127.0.0.1", resolve));
  socket.on("message", (message) => datagrams.push(JSON.parse(message.toString())));
  const got = { messages: [], faults: [] };
  await run(["--dataset", "flight", "--sliding_window", "--realtime", "--output", "out", "--page", "0", "--publish", "foxglove",
    "--publish", "mcap:out.mcap", "--publish", "udp://127.0.0.1:" + socket.address().port],
    (line) => { if (line.startsWith("foxglove ")) followFoxglove(line.split(/ +/)[1], got); });
  socket.close();
  const rows = statesCsv();
  assert.deepStrictEqual(got.faults, []);
  assert.strictEqual(got.info.name, "tagtwist");
  for (const [topic, message] of got.messages) checkMessage(topic, message, rows);
  const counts = countTopics(got.messages);
  console.log("foxglove:", JSON.stringify(counts), "of", rows.size, "frames");
  assert(counts["/tagtwist/body/state"] > 0.8 * rows.size && counts["/tagtwist/map"] === 1 && counts["/tagtwist/body/cam0/image"] > 5);
  for (const state of datagrams) checkState(state, rows);
  console.log("udp:", datagrams.length, "datagrams");
  assert.strictEqual(datagrams.length, rows.size);

  const file = readMcap("out.mcap");
  for (const [topic, message] of file.messages) checkMessage(topic, message, rows);
  console.log("mcap:", JSON.stringify(countTopics(file.messages)));
  assert(file.done);
  assert.strictEqual(countTopics(file.messages)["/tagtwist/body/state"], rows.size);

  const indexed = await readIndexed("out.mcap");
  for (const [topic, message] of indexed.messages) checkMessage(topic, message, rows);
  assert.deepStrictEqual(countTopics(indexed.messages), countTopics(file.messages));
  const { statistics, chunkIndexes } = indexed.reader;
  console.log("mcap:", chunkIndexes.length, "chunks");
  assert(chunkIndexes.length >= seconds && statistics.chunkCount === chunkIndexes.length);
  assert.strictEqual(Number(statistics.messageCount), file.messages.length);
  const startTime = statistics.messageStartTime + 2500000000n;
  const late = await readIndexed("out.mcap", { topics: ["/tagtwist/body/state"], startTime });
  const wanted = [...rows.keys()].filter((key) => BigInt(key.replace(".", "")) >= startTime);
  assert.deepStrictEqual(late.messages.map(([, state]) => keyOf(state.stamp)), wanted);

  // Cut anywhere the file reads as far as its last whole chunk.
  const whole = fs.readFileSync(at("out.mcap"));
  fs.writeFileSync(at("cut.mcap"), whole.subarray(0, Math.floor(whole.length / 2)));
  const cut = readMcap("cut.mcap");
  assert(!cut.done && cut.messages.length > 0.2 * file.messages.length);
  await checkKilled();
}

main().catch((fault) => { console.error(fault); process.exitCode = 1; });
