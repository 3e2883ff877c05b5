// What tests of streams have in common: the packages @foxglove/ws-protocol, @mcap/core and ws, to which NODE_PATH leads
// (exit status 77 where they are not), the folder of programs, and a folder that goes in the end.
"use strict";
const assert = require("node:assert");
const fs = require("node:fs");
const os = require("node:os");
const path = require("node:path");

let foxglove, mcap, ws;
try {
  foxglove = require("@foxglove/ws-protocol");
  mcap = require("@mcap/core");
  ws = require("ws");
} catch (missing) {
  console.log("skipped: " + missing.message.split("\n")[0]);
  process.exit(77);
}
const programs = path.resolve(process.argv[2]);
const folder = fs.mkdtempSync(path.join(os.tmpdir(), "tagtwist-streams-"));
process.on("exit", () => fs.rmSync(folder, { recursive: true, force: true }));
const at = (name) => path.join(folder, name);

// A table by the names of its columns.
function rowsOf(name) {
  const [head, ...lines] = fs.readFileSync(at(name), "utf8").trim().split("\n");
  const names = head.split(",");
  return lines.map((line) => Object.fromEntries(line.split(",").map((cell, i) => [names[i], cell])));
}
const keyOf = (stamp) => stamp.sec + "." + String(stamp.nsec).padStart(9, "0");

// All topics, as [topic, message] into got.messages; what is wrong into got.faults.
function followFoxglove(link, got) {
  const client = new foxglove.FoxgloveClient({ ws: new ws.WebSocket(link, [foxglove.FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
  const topics = new Map();
  client.on("error", (fault) => got.faults.push(String(fault)));
  client.on("serverInfo", (info) => (got.info = info));
  client.on("advertise", (channels) => {
    for (const channel of channels) {
      assert.strictEqual(channel.schemaEncoding, "jsonschema");
      JSON.parse(channel.schema);
      topics.set(client.subscribe(channel.id), channel.topic);
    }
  });
  client.on("message", (message) => {
    got.messages.push([topics.get(message.subscriptionId), JSON.parse(Buffer.from(message.data.buffer, message.data.byteOffset, message.data.byteLength).toString())]);
  });
}

function readMcap(name) {
  const reader = new mcap.McapStreamReader();
  reader.append(fs.readFileSync(at(name)));
  const topics = new Map(), messages = [];
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Channel") topics.set(record.id, record.topic);
    if (record.type === "Message") messages.push([topics.get(record.channelId), JSON.parse(Buffer.from(record.data).toString())]);
  }
  return { messages, done: reader.done() };
}

function countTopics(messages) {
  const counts = {};
  for (const [topic] of messages) counts[topic] = (counts[topic] || 0) + 1;
  return counts;
}

module.exports = { mcap, programs, folder, at, rowsOf, keyOf, followFoxglove, readMcap, countTopics };
