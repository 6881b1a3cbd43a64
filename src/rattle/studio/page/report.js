// The Report tab: the page of the report in a frame that runs no scripts, to read, print or save.

import { h } from "./dom.js";

export class Report {
  constructor() {
    this.frame = h("iframe", { class: "paper", title: "Report", sandbox: "allow-same-origin allow-modals", hidden: true });
    this.save = h("a", { class: "button", download: "report.html", hidden: true }, "Save as HTML");
    this.print = h("button", { hidden: true, onclick: () => this.frame.contentWindow.print() }, "Print or save as PDF");
    this.el = h("div", { class: "report-of" }, h("div", { class: "buttons" }, this.save, this.print), this.frame);
  }

  show(page, title) {
    if (this.address) URL.revokeObjectURL(this.address);
    this.address = URL.createObjectURL(new Blob([page], { type: "text/html" }));
    this.save.href = this.frame.src = this.address;
    this.save.download = `${title.replace(/[^\w-]+/g, "-").replace(/^-+|-+$/g, "").slice(0, 60) || "report"}.html`;
    for (const one of [this.frame, this.save, this.print]) one.hidden = false;
  }
}
