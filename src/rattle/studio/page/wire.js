// The web socket to the studio: messages as JSON in both directions, in the order in which they are sent.

export class Wire {
  constructor() {
    this.early = []; // what was to be sent before the studio has answered
    this.socket = new WebSocket(new URL("ws", location.href.replace(/^http/, "ws")));
    this.socket.addEventListener("open", () => {
      for (const text of this.early) this.socket.send(text);
      this.early = null;
    });
  }

  send(message) {
    const text = JSON.stringify(message);
    if (this.early) this.early.push(text);
    else if (this.socket.readyState === WebSocket.OPEN) this.socket.send(text);
  }

  // heard: called with every message of the studio; ended: when there will be no more.
  listen(heard, ended) {
    this.socket.addEventListener("message", (event) => heard(JSON.parse(event.data)));
    this.socket.addEventListener("close", ended);
  }
}
