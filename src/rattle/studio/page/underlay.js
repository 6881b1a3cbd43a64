// A photograph or drawing of the real machine below the sheet: chosen from a file, scaled by two points of known distance.

import { h } from "./dom.js";

const SHARE = 0.7; // of the sheet that a new picture takes
const LARGEST = 12e6; // bytes of a file

export class Underlay {
  constructor(edit) {
    this.edit = edit;
    this.input = h("input", { type: "file", accept: "image/*", hidden: true, "aria-label": "File of the picture", onchange: () => this.take(this.input.files[0]) });
    this.photo = null;
    this.spots = null;
    this.images = new Map(); // by the name of the file
    this.asked = new Set(); // files that the studio was asked for: of one that is missing it says so once
  }

  // Another model: its pictures may have the names of others.
  forget() {
    this.images.clear();
    this.asked.clear();
    this.photo = this.spots = null;
  }

  ask() {
    this.input.value = "";
    this.input.click();
  }

  // What scripts see.
  get told() {
    const { photo } = this;
    return photo ? { width: photo.width, height: photo.height, scale: photo.scale, origin: photo.origin, angle: photo.angle } : null;
  }

  async take(file) {
    if (!file) return;
    const { board } = this.edit;
    if (file.size > LARGEST) { this.edit.refuse(`${file.name} has ${Math.round(file.size / 1e6)} MB; a picture may have up to ${LARGEST / 1e6} MB`); return; }
    const data = await new Promise((done) => {
      const reader = new FileReader();
      reader.addEventListener("load", () => done(reader.result));
      reader.readAsDataURL(file);
    });
    const image = await this.load(file.name, data);
    if (!image) { this.edit.refuse(`${file.name} is not a picture that this browser can show`); return; }
    const size = Math.min(SHARE * board.width / image.naturalWidth, SHARE * board.height / image.naturalHeight) / board.view.scale;
    const scale = Number(size.toPrecision(3)), middle = board.inPlane([board.width / 2, board.height / 2]);
    const origin = [middle[0] - scale * image.naturalWidth / 2, middle[1] - scale * image.naturalHeight / 2].map((x) => Number(x.toPrecision(4)));
    this.edit.act({ act: "picture", name: file.name, data: data.slice(data.indexOf(",") + 1), scale, origin, angle: 0 });
    this.edit.say("click two points of the picture whose distance is known");
  }

  async load(name, data) {
    const image = new Image();
    image.src = data;
    try { await image.decode(); } catch { return null; }
    this.images.set(name, image);
    return image;
  }

  // picture: of the text, {file, scale, origin, angle} in SI numbers, or null.
  show(picture) {
    this.wanted = picture;
    if (!picture) this.photo = null;
    else if (this.images.has(picture.file)) {
      const image = this.images.get(picture.file);
      this.photo = { image, width: image.naturalWidth, height: image.naturalHeight, scale: picture.scale, origin: picture.origin, angle: picture.angle };
    } else if (!this.asked.has(picture.file)) {
      this.photo = null;
      this.asked.add(picture.file);
      this.edit.send({ do: "picture-file", name: picture.file });
    }
    this.edit.board.photo = this.photo;
    this.edit.board.invalidate();
  }

  // The studio has read the file of a picture.
  async hear({ name, data }) {
    if (await this.load(name, data)) this.show(this.wanted);
  }
}
