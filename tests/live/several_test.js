// Two boards before two cameras that stand: each body and each camera by its name in every stream, with the numbers of
// states_NAME.csv. node several_test.js PROGRAMS; NODE_PATH and exit status 77 as of streams.js.
"use strict";
const assert = require("node:assert");
const { spawn, spawnSync } = require("node:child_process");
const dgram = require("node:dgram");
const fs = require("node:fs");
const path = require("node:path");
const { programs, folder, at, rowsOf, keyOf, followFoxglove, readMcap, countTopics } = require("./streams.js");

const BODIES = ["board", "toy"], CAMERAS = ["left", "right"];
const cameras = "cameras:\n" + CAMERAS.map((name, i) => `  - name: ${name}
    camera: {width: 320, height: 240, fx: ${220 + 10 * i}, fy: ${220 + 10 * i}, cx: 160, cy: 120}
    mounted_on: world
    cam_from_world: {rotation: [1, 0, 0, 0, -1, 0, 0, 0, -1], translation_m: [${i ? -0.15 : 0.15}, 0, 1]}
`).join("");
// Four tags about a place.
const tags = (indent, first, x) => indent + "tags:\n" + [0, 1, 2, 3].map((i) => indent + `  - {id: ${first + i}, size_m: 0.1, ` +
  `position_m: [${(x + (i % 2 ? 0.07 : -0.07)).toFixed(2)}, ${i < 2 ? 0.07 : -0.07}, 0]}\n`).join("");

function make() {
  // Both boards are rendered as one, which moves; what is estimated knows nothing of that.
  const both = tags("  ", 0, -0.17) + tags("  ", 10, 0.17).replace(/^.*\n/, "");
  fs.writeFileSync(at("rendered.yaml"), cameras + "tag_map:\n" + both);
  fs.writeFileSync(at("two.yaml"), cameras + "tag_map:\n  bodies:\n" + BODIES.map((name, i) => `    - name: ${name}\n` +
    tags("      ", 10 * i, 0)).join(""));
  let lines = "";
  for (let i = 0; i <= 250; i++) {
    const t = 0.01 * i, angle = 0.3 * Math.sin(2 * t);
    lines += `${1 + t} ${0.05 * Math.cos(2 * t)} ${0.05 * Math.sin(2 * t)} 0 0 0 ${Math.sin(angle / 2)} ${Math.cos(angle / 2)}\n`;
  }
  fs.writeFileSync(at("path.tum"), lines);
  const made = spawnSync(path.join(programs, "tagtwist_simulate"), ["--output", "flight", "--config", "rendered.yaml", "--trajectory", "path.tum",
    "--rate", "20", "--duration", "2", "--imu_rate", "0"], { cwd: folder });
  assert.strictEqual(made.status, 0, String(made.stderr));
}

// What a run of `more` gives by foxglove, whose client counts, by datagrams and by its files.
function run(more) {
  return new Promise((resolve, reject) => {
    const socket = dgram.createSocket("udp4"), got = { datagrams: [], messages: [], faults: [] };
    socket.on("message", (message) => got.datagrams.push(JSON.parse(message.toString())));
    socket.bind(0, "127.0.0.1", () => {
      const program = spawn(path.join(programs, "tagtwist_estimate"), ["--dataset", "flight", "--config", "two.yaml", "--sliding_window", "--output", "out",
        "--publish", "mcap:out.mcap", "--publish", "csv:rows.csv", "--record", "rec", "--publish", "udp://127.0.0.1:" + socket.address().port, ...more], { cwd: folder });
      let error = "";
      program.stderr.on("data", (data) => (error += data));
      program.stdout.on("data", (data) => {
        const link = /foxglove +(\S+)/.exec(String(data));
        if (link) followFoxglove(link[1], got);
      });
      program.on("exit", (status) => { socket.close(); status === 0 ? resolve(got) : reject(new Error("status " + status + ": " + error)); });
    });
  });
}

function checkState(state, rows) {
  const row = rows[state.body].get(keyOf(state.stamp));
  assert(row, state.body + " has no row at " + keyOf(state.stamp));
  assert.strictEqual(state.status, row.status);
  assert.strictEqual(String(state.n_tags), row.n_tags);
  if (state.position) ["x", "y", "z"].forEach((c, i) => assert.strictEqual(state.position[i], Number(row[c])));
  if (state.position) ["wx_body", "wy_body", "wz_body"].forEach((c, i) => assert.strictEqual(state.angular_velocity[i], Number(row[c])));
  if (state.sigma) assert.strictEqual(state.sigma[11], Number(row.sigma_wz));
}

function checkMessages(messages, rows) {
  const counts = countTopics(messages), images = new Set();
  for (const [topic, message] of messages) {
    const [, , name, what] = topic.split("/");
    if (what === "state") { assert.strictEqual(message.body, name); checkState(message, rows); }
    if (what === "twist") assert.strictEqual(message.angular_frame_id, name);
    if (what === "image") { assert.strictEqual(message.frame_id, name); images.add(name + message.data); }
    if (topic === "/tf") {
      assert.deepStrictEqual(message.transforms.map((t) => [t.parent_frame_id, t.child_frame_id]), [...BODIES, ...CAMERAS].map((child) => ["world", child]));
    }
    if (topic === "/tagtwist/map") assert.deepStrictEqual(message.entities.map((e) => [e.frame_id, e.texts.length]), [["board", 4], ["toy", 4]]);
  }
  for (const body of BODIES) for (const what of ["state", "pose", "twist"]) assert(counts["/tagtwist/" + body + "/" + what] > 3, body + " " + what);
  for (const camera of CAMERAS) assert(counts["/tagtwist/" + camera + "/image"] > 1, camera);
  assert.strictEqual(images.size, CAMERAS.reduce((n, camera) => n + counts["/tagtwist/" + camera + "/image"], 0), "an image came twice");
  return counts;
}

const statesOf = () => Object.fromEntries(BODIES.map((name) => [name, new Map(rowsOf("out/states_" + name + ".csv").map((row) => [row.t, row]))]));

async function main() {
  make();
  const files = await run([]);
  let rows = statesOf();
  const file = readMcap("out.mcap");
  assert(file.done);
  const n = rows.board.size, counts = checkMessages(file.messages, rows);
  console.log("mcap:", JSON.stringify(counts), "of", n, "frames");
  for (const name of BODIES) {
    assert.strictEqual(counts["/tagtwist/" + name + "/state"], n);
    const last = [...rows[name].values()].pop();
    assert.strictEqual(last.status, "ok");
  }
  for (const name of CAMERAS) {
    assert.strictEqual(counts["/tagtwist/" + name + "/image"], n);
    assert.strictEqual(rowsOf("rec/" + name + "/timestamps.csv").length, n);
  }
  assert.strictEqual(files.datagrams.length, BODIES.length * n);
  for (const state of files.datagrams) {
    assert.deepStrictEqual(state.cameras, CAMERAS);
    checkState(state, rows);
  }
  const streamed = rowsOf("rows.csv");
  assert.strictEqual(streamed.length, BODIES.length * n);
  for (const { body, ...row } of streamed) assert.deepStrictEqual(row, { ...rows[body].get(row.t) });
  // What was recorded is what it was recorded from.
  const again = spawnSync(path.join(programs, "tagtwist_estimate"), ["--dataset", "rec", "--config", "two.yaml", "--sliding_window", "--output", "again"], { cwd: folder });
  assert.strictEqual(again.status, 0, String(again.stderr));
  assert.strictEqual(fs.readFileSync(at("again/states_toy.csv"), "utf8"), fs.readFileSync(at("out/states_toy.csv"), "utf8"));

  fs.rmSync(at("rec"), { recursive: true });
  const live = await run(["--realtime", "--page", "0", "--publish", "foxglove"]);
  rows = statesOf();
  assert.deepStrictEqual(live.faults, []);
  console.log("foxglove:", JSON.stringify(checkMessages(live.messages, rows)));
  for (const state of live.datagrams) checkState(state, rows);
}

main().catch((fault) => { console.error(fault); process.exitCode = 1; });
