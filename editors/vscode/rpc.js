// The Language Server Protocol over a process's standard streams, without any library: requests, notifications.
"use strict";
const { spawn } = require("child_process");

class Connection {
  constructor(command, args, cwd, onNotification, onExit) {
    this.next = 1;
    this.waiting = new Map();
    this.buffer = Buffer.alloc(0);
    this.process = spawn(command, args, { cwd });
    this.process.on("error", (error) => onExit(error.message));
    this.process.on("exit", (code) => onExit(`the server ended with status ${code}`));
    this.process.stdin.on("error", () => {});
    this.process.stdout.on("data", (chunk) => this.read(chunk, onNotification));
  }

  read(chunk, onNotification) {
    this.buffer = Buffer.concat([this.buffer, chunk]);
    for (;;) {
      const end = this.buffer.indexOf("\r\n\r\n");
      if (end < 0) return;
      const length = Number(/Content-Length: (\d+)/i.exec(this.buffer.slice(0, end).toString())[1]);
      if (this.buffer.length < end + 4 + length) return;
      const message = JSON.parse(this.buffer.slice(end + 4, end + 4 + length).toString("utf8"));
      this.buffer = this.buffer.slice(end + 4 + length);
      this.take(message, onNotification);
    }
  }

  take(message, onNotification) {
    if (message.id !== undefined && message.method === undefined) {
      const { resolve, reject } = this.waiting.get(message.id) || {};
      this.waiting.delete(message.id);
      if (message.error && reject) reject(new Error(message.error.message));
      else if (resolve) resolve(message.result);
    } else if (message.id !== undefined) {
      this.send({ id: message.id, result: null });
    } else {
      onNotification(message.method, message.params);
    }
  }

  send(message) {
    const body = Buffer.from(JSON.stringify({ jsonrpc: "2.0", ...message }), "utf8");
    this.process.stdin.write(`Content-Length: ${body.length}\r\n\r\n`);
    this.process.stdin.write(body);
  }

  notify(method, params) {
    this.send({ method, params });
  }

  request(method, params) {
    const id = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.send({ id, method, params });
    });
  }

  async close() {
    await this.request("shutdown").catch(() => {});
    this.notify("exit");
  }
}

module.exports = { Connection };
