// The render queue: films as they are made, each with its newest frame.

import { ask, askBytes, guarded } from "./api.js";

const REFRESH = 1000; // ms

export class Renders {
  constructor(report) {
    this.report = report;
    this.box = document.getElementById("renders");
    this.pictures = new Map();
    setInterval(() => this.box.hidden || this.#refreshQuietly(), REFRESH);
  }

  async refresh() {
    const { renders } = await ask("renders");
    const articles = renders.map((one) => this.#article(one));
    const none = Object.assign(document.createElement("p"), {
      textContent: "Nothing is being rendered. Open a scene and press Render.",
    });
    this.box.replaceChildren(...(articles.length ? articles : [none]));
    for (const one of renders) {
      if (one.state === "rendering" || !this.pictures.has(one.number)) await this.#picture(one);
    }
  }

  #refreshQuietly() {
    return guarded(this.report, () => this.refresh());
  }

  async #picture({ number, state }) {
    const { bytes } = await askBytes("rendered-frame", { number });
    if (bytes.byteLength) {
      URL.revokeObjectURL(this.pictures.get(number));
      this.pictures.set(number, URL.createObjectURL(new Blob([bytes], { type: "image/png" })));
    } else if (state !== "rendering" && state !== "waiting") this.pictures.set(number, "data:,");
  }

  #openFolder(number) {
    return guarded(this.report, async () => {
      this.report((await ask("open-folder", { number })).folder);
    });
  }

  #article({ number, scene, preset, state, stage, text }) {
    const article = document.createElement("article");
    const picture = document.createElement("img");
    const src = this.pictures.get(number) ?? "data:,";
    Object.assign(picture, { src, alt: src === "data:," ? "" : `newest frame of ${scene}` });
    const about = document.createElement("div");
    const line = (tag, textContent) => about.append(Object.assign(document.createElement(tag), { textContent }));
    line("strong", `${scene}, ${preset}: ${state}`);
    line("p", state === "rendering" ? stage : text);
    if (state === "rendering" || state === "waiting") {
      const stop = Object.assign(document.createElement("button"), { textContent: "Stop" });
      stop.onclick = async () => {
        await ask("stop-render", { number });
        this.refresh();
      };
      about.append(stop);
    }
    if (state !== "waiting") {
      const folder = Object.assign(document.createElement("button"), { textContent: "Open the folder" });
      folder.onclick = () => this.#openFolder(number);
      about.append(folder);
    }
    article.append(picture, about);
    return article;
  }
}
